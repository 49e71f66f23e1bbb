#pragma once

#include <cmath>

#include "mesh.h"
#include "samara/pgd/linear/parametric_problem.h"

/// -div(k grad u) = s f(x) on the unit square, u = 0 on its border; k is 1 outside a disc and a parameter
/// inside, the source has strength s and a width that is fixed. The mesh is one axis.
struct HeatedDisc {
  Mesh mesh;
  samara::pgd::Axis place, k, s;

  explicit HeatedDisc(int cells)
      : mesh(cells),
        place(samara::pgd::Axis::imported({"place", "1", samara::pgd::AxisRole::space}, mesh.mass)),
        k(samara::pgd::Axis::chebyshev(
            {"k", "W/(m K)", samara::pgd::AxisRole::parameter, samara::pgd::Transform::logarithm},
            0.1, 10.0, 16)),
        s(samara::pgd::Axis::chebyshev({"s", "W/m^2"}, 1.0, 3.0, 2)) {}

  /// Nodal values of the source, off the disc's centre.
  Eigen::VectorXd source() const {
    Eigen::VectorXd f(place.size());
    for (int i = 0; i < place.size(); ++i) {
      const Eigen::Vector2d from = mesh.place(i) - Eigen::Vector2d(0.35, 0.6);
      f[i] = std::exp(-from.squaredNorm() / 0.02);
    }
    return f;
  }

  samara::pgd::ParametricProblem problem() const {
    using namespace samara::pgd;
    ParametricProblem disc({place, k, s});
    disc.add_term({{"place", ModeOperator::sparse(mesh.stiffness_plate)}});
    disc.add_term({{"place", ModeOperator::sparse(mesh.stiffness_disc)},
                   {"k", ModeOperator::diagonal(k.nodes())}});
    const Eigen::VectorXd load = mesh.mass * source();
    disc.add_source({{"place", load}, {"s", s.nodes()}});
    disc.know("place", mesh.border);
    return disc;
  }
};
