#include "samara/pgd/resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "samara/pgd/random.h"
#include "samara/pgd/separated_tensor.h"

namespace samara::pgd {

namespace {

/// Legendre coefficients from values at the nodes: the inverse of P_j(node i).
Eigen::MatrixXd to_legendre(const Eigen::VectorXd& nodes) {
  const Eigen::Index n = nodes.size();
  Eigen::MatrixXd values(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    values(i, 0) = 1.0;
    if (n > 1) values(i, 1) = nodes[i];
    for (Eigen::Index j = 1; j + 1 < n; ++j) {
      const auto p = static_cast<double>(j);
      values(i, j + 1) = ((2 * p + 1) * nodes[i] * values(i, j) - p * values(i, j - 1)) / (p + 1);
    }
  }
  return values.inverse();
}

}  // namespace

double highest_coefficients(const SeparatedField& field, int axis, std::span<const double> scales) {
  const Axis& own = field.axes()[static_cast<std::size_t>(axis)];
  if (own.basis() == Basis::p1) return 0.0;
  const Eigen::MatrixXd coefficients =
      to_legendre(own.element_basis().nodes()).bottomRows(std::min(2, own.degree()));
  SeparatedTensor tensor;
  tensor.weights = Eigen::VectorXd::Ones(field.rank());
  tensor.factors.push_back(
      Eigen::Map<const Eigen::VectorXd>(scales.data(), static_cast<Eigen::Index>(scales.size()))
          .cwiseInverse()
          .asDiagonal() *
      field.weights());
  std::size_t own_mode = 0;
  for (int k = 0; k < field.axis_count(); ++k) {
    const Axis& other = field.axes()[static_cast<std::size_t>(k)];
    const Eigen::MatrixXd& factor = field.factors()[static_cast<std::size_t>(k)];
    if (k == axis) own_mode = tensor.factors.size();
    // Weights of the first Radau node are zero up to round-off, possibly below.
    const Eigen::VectorXd root = (other.weights() / other.length()).cwiseMax(0.0).cwiseSqrt();
    tensor.factors.emplace_back(root.asDiagonal() * factor);
  }
  double largest = 0.0;
  for (int e = 0; e < own.elements(); ++e) {
    tensor.factors[own_mode] = coefficients * field.factors()[static_cast<std::size_t>(axis)].middleRows(
                                                  e * own.degree(), own.degree() + 1);
    largest = std::max(largest, fast_norm(tensor));
  }
  return largest;
}

std::vector<double> sampled_ranges(const SeparatedField& field, int samples, std::uint64_t seed) {
  Random random(seed);
  SeparatedField::Workspace workspace = field.make_workspace();
  Eigen::VectorXd values(field.output_count());
  Eigen::VectorXd smallest =
      Eigen::VectorXd::Constant(field.output_count(), std::numeric_limits<double>::infinity());
  Eigen::VectorXd largest = -smallest;
  std::vector<double> x(field.axes().size());
  for (int i = 0; i < samples; ++i) {
    for (std::size_t k = 0; k < x.size(); ++k) {
      // Ends of intervals are where monotone solutions have their extremes.
      const Axis& axis = field.axes()[k];
      const int end = random.below(4);
      x[k] = end == 0 ? axis.lower() : end == 1 ? axis.upper() : axis.nodes()[random.below(axis.size())];
    }
    field.evaluate(x, values, workspace);
    smallest = smallest.cwiseMin(values);
    largest = largest.cwiseMax(values);
  }
  const Eigen::VectorXd range = largest - smallest;
  return {range.begin(), range.end()};
}

}  // namespace samara::pgd
