#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "samara/models/integrators/linear_system.h"
#include "samara/pgd/axes/axis_forms.h"

/// Parameters of the model "heat_rod", SI.
struct Rod {
  double conductivity, capacity, length, left, right, amplitude;
};

/// The temperature of a rod by CVODE on quadratic finite elements which crowd at its ends: the method of lines, on
/// nodes that have nothing to do with those of a codebook.
/// @returns places x times; times begin with 0
inline Eigen::MatrixXd rod_by_cvode(const Rod& rod, const std::vector<double>& times,
                                    const Eigen::VectorXd& places) {
  using namespace samara;
  constexpr int kElements = 60;
  Eigen::VectorXd borders(kElements + 1);
  for (int e = 0; e <= kElements; ++e)
    borders[e] = 0.5 * rod.length * (1.0 - std::cos(std::numbers::pi * e / kElements));
  const pgd::Axis x = pgd::Axis::p2({"x", "m"}, borders);
  const int inner = x.size() - 2;
  const auto between = [&](const pgd::SparseMatrix& matrix) {
    return pgd::SparseMatrix(matrix.block(1, 1, inner, inner));
  };
  // What the line between the ends does not hold decays; the line is steady.
  const Eigen::VectorXd s = x.nodes() / rod.length;
  const Eigen::VectorXd start = 4.0 * rod.amplitude * s.array() * (1.0 - s.array());
  const models::LinearSystem system{
      rod.capacity * between(x.mass()), rod.conductivity * between(x.stiffness()), {}};
  const double size = std::max(1e-3, std::abs(rod.amplitude));
  const Eigen::MatrixXd states =
      models::integrate_linear(system, start.segment(1, inner), times,
                               {.relative_tolerance = 1e-8, .absolute_tolerance = 1e-9 * size});
  Eigen::MatrixXd result(places.size(), static_cast<Eigen::Index>(times.size()));
  for (Eigen::Index i = 0; i < result.cols(); ++i) {
    Eigen::VectorXd nodal = Eigen::VectorXd::Zero(x.size());
    nodal.segment(1, inner) = states.col(i);
    const pgd::AxisFunction at = pgd::interpolated(x, nodal);
    for (Eigen::Index j = 0; j < places.size(); ++j)
      result(j, i) = at(places[j]) + rod.left + (rod.right - rod.left) * places[j] / rod.length;
  }
  return result;
}
