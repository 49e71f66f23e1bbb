#pragma once

#include <cmath>
#include <numbers>

#include "samara/pgd/axes/axis_forms.h"
#include "samara/pgd/linear/parametric_problem.h"

/// du/dt = k d2u/dx2 on (0,1), u(t,0) = g, u(t,1) = 0, u(0,x) = g (1 - x)^2 + a sin(pi x), over conductivity
/// k, boundary value g and initial amplitude a at once.
struct Heat {
  samara::pgd::Axis x, t, k, g, a;

  explicit Heat(int elements = 40)
      : x(samara::pgd::Axis::p1({"x", "m", samara::pgd::AxisRole::space}, 0.0, 1.0, elements + 1)),
        t(samara::pgd::Axis::radau({"t", "s", samara::pgd::AxisRole::time}, graded_times(), 5)),
        k(samara::pgd::Axis::chebyshev({"k", "m^2/s"}, 0.1, 1.0, 20)),
        g(samara::pgd::Axis::chebyshev({"g", "K", samara::pgd::AxisRole::boundary}, 0.0, 2.0, 2)),
        a(samara::pgd::Axis::chebyshev({"a", "K", samara::pgd::AxisRole::initial}, -1.0, 1.0, 2)) {}

  /// The shortest waves die out first: elements grow from 1e-3 s.
  static Eigen::VectorXd graded_times() {
    constexpr int kElements = 10;
    Eigen::VectorXd borders(kElements + 1);
    borders[0] = 0.0;
    for (int e = 1; e <= kElements; ++e)
      borders[e] = std::pow(10.0, -3.0 + 3.0 * (e - 1) / (kElements - 1));
    return borders;
  }

  samara::pgd::ParametricProblem problem() const {
    using namespace samara::pgd;
    ParametricProblem heat({x, t, k, g, a});
    // Weak in x, collocated in t, k, g and a.
    heat.add_term({{"t", ModeOperator::sparse(t.derivative())}});
    heat.add_term(
        {{"x", ModeOperator::sparse(x.stiffness())}, {"k", ModeOperator::diagonal(k.nodes())}});
    // The data are coordinates: of the border's value and of the initial state, which the lift keeps at all
    // times, so that what is left starts from zero.
    heat.know("x", {0, x.size() - 1});
    heat.know("t", {0});
    heat.measure("x", x.stiffness());
    const Eigen::VectorXd from_left =
        nodal_values(x, [](double s) { return (1.0 - s) * (1.0 - s); });
    const Eigen::VectorXd sine =
        nodal_values(x, [](double s) { return std::sin(std::numbers::pi * s); });
    heat.add_to_lift({{"x", from_left}, {"g", g.nodes()}});
    heat.add_to_lift({{"x", sine}, {"a", a.nodes()}});
    return heat;
  }
};
