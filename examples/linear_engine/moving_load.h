#pragma once

#include <Eigen/LU>

#include "samara/pgd/axes/axis_forms.h"
#include "samara/pgd/linear/parametric_problem.h"

/// u_t - u_xx / 20 = delta(x - 0.1 - 0.8 t) on (0,1), t in [0,1], u = 0 on the border and at t = 0: a unit
/// point load that crosses the domain. Linear elements in x, implicit Euler in t (one Radau point an
/// element). The source has one product for every time.
struct MovingLoad {
  samara::pgd::Axis x =
      samara::pgd::Axis::p1({"x", "1", samara::pgd::AxisRole::space}, 0.0, 1.0, 101);
  samara::pgd::Axis t =
      samara::pgd::Axis::radau({"t", "1", samara::pgd::AxisRole::time}, 0.0, 1.0, 100, 1);
  static constexpr double kConductivity = 0.05;

  static double place(double time) { return 0.1 + 0.8 * time; }

  samara::pgd::ParametricProblem problem() const {
    using namespace samara::pgd;
    ParametricProblem load({x, t});
    load.add_term({{"t", ModeOperator::sparse(t.derivative())}});
    load.add_term({{"x", ModeOperator::sparse(x.stiffness())}}, kConductivity);
    for (int j = 1; j < t.size(); ++j) {
      load.add_source(
          {{"x", point_load(x, place(t.nodes()[j]))}, {"t", Eigen::VectorXd::Unit(t.size(), j)}});
    }
    load.know("x", {0, x.size() - 1});
    load.know("t", {0});
    load.measure("x", x.stiffness());
    return load;
  }

  /// The same, step by step: inner nodes x times but the first.
  Eigen::MatrixXd march() const {
    const Eigen::Index n = x.size() - 2;
    const Eigen::MatrixXd mass = Eigen::MatrixXd(x.mass()).block(1, 1, n, n);
    const Eigen::MatrixXd stiffness = Eigen::MatrixXd(x.stiffness()).block(1, 1, n, n);
    const double step = t.nodes()[1] - t.nodes()[0];
    const Eigen::PartialPivLU<Eigen::MatrixXd> matrix(mass / step + kConductivity * stiffness);
    Eigen::MatrixXd u(n, t.size() - 1);
    Eigen::VectorXd before = Eigen::VectorXd::Zero(n);
    for (int j = 1; j < t.size(); ++j) {
      const Eigen::VectorXd load = samara::pgd::point_load(x, place(t.nodes()[j])).segment(1, n);
      before = matrix.solve(mass * before / step + load);
      u.col(j - 1) = before;
    }
    return u;
  }
};
