#include "samara/pgd/axes/axis_fourier.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "samara/base/require.h"
#include "samara/pgd/axes/axis_checks.h"

namespace samara::pgd {

namespace {
/// D_ij = (pi / period) (-1)^(i - j) / sin(pi (i - j) / n), for odd n. Reference: Trefethen, Spectral Methods
/// in MATLAB (2000), chapter 3.
SparseMatrix fourier_differentiation(int n, double period) {
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      if (i == j) continue;
      const double sign = (i - j) % 2 == 0 ? 1.0 : -1.0;
      d(i, j) = sign * std::numbers::pi / period / std::sin(std::numbers::pi * (i - j) / n);
    }
  }
  return d.sparseView();
}
}  // namespace

AxisTables fourier_tables(AxisLabel label, double lower, double upper, int count) {
  require(count >= 3 && count % 2 == 1, "the number of nodes", count, "an odd number, at least 3,",
          axis_text(label));
  check_increasing(label, Eigen::Vector2d(lower, upper), 2);
  check_no_transform(label, "fourier");
  AxisTables tables;
  tables.label = std::move(label);
  tables.basis = Basis::fourier;
  tables.lower = lower;
  tables.upper = upper;
  tables.measure = upper - lower;
  // Products of two basis functions have degree count - 1, where the sum over the nodes is still the
  // integral.
  const double weight = tables.measure / count;
  tables.nodes = lower + weight * Eigen::ArrayXd::LinSpaced(count, 0.0, count - 1.0);
  tables.weights = Eigen::VectorXd::Constant(count, weight);
  tables.mass = SparseMatrix(tables.weights.asDiagonal());
  tables.derivative = fourier_differentiation(count, tables.measure);
  const SparseMatrix& d = *tables.derivative;
  tables.gradient = SparseMatrix(weight * d);
  tables.stiffness = SparseMatrix(weight * (d.transpose() * d));
  return tables;
}

/// The second barycentric formula of Henrici (Numerische Mathematik 33, 1979) with weights
/// (-1)^j / sin(pi (x - x_j) / period), for odd numbers of nodes: weights sum to one and stay accurate beside
/// the nodes.
void interpolate_fourier(const AxisTables& tables, double x, InterpolationStencil& stencil,
                         bool with_derivative) {
  const double length = tables.upper - tables.lower;
  const bool inside = x >= tables.lower && x < tables.upper;
  const double wrapped = inside ? x : x - length * std::floor((x - tables.lower) / length);
  const Eigen::VectorXd& nodes = tables.nodes;
  stencil.first = 0;
  double sum = 0.0;
  for (Eigen::Index j = 0; j < nodes.size(); ++j) {
    const double difference = wrapped - nodes[j];
    if (difference == 0.0) {
      stencil.value.setZero();
      stencil.value[j] = sum = 1.0;
      break;
    }
    stencil.value[j] = (j % 2 == 0 ? 1.0 : -1.0) / std::sin(std::numbers::pi * difference / length);
    sum += stencil.value[j];
  }
  stencil.value /= sum;
  if (!with_derivative) return;
  // The derivative of a function of the space lies in the space: it is its own interpolation.
  const SparseMatrix& d = *tables.derivative;
  for (Eigen::Index j = 0; j < nodes.size(); ++j) stencil.derivative[j] = d.col(j).dot(stencil.value);
}

}  // namespace samara::pgd
