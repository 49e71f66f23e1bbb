#include "samara/pgd/fields/resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>

#include "samara/pgd/tensors/random.h"

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

/// Cosine and sine coefficients of the two highest harmonics from values at n = 2m + 1 nodes.
Eigen::MatrixXd highest_harmonics(int n) {
  const int highest = (n - 1) / 2;
  const int count = std::min(2, highest);
  Eigen::MatrixXd rows(2 * count, n);
  for (int i = 0; i < count; ++i) {
    const Eigen::ArrayXd angle =
        Eigen::ArrayXd::LinSpaced(n, 0.0, n - 1.0) * (2.0 * std::numbers::pi * (highest - i) / n);
    rows.row(2 * i) = 2.0 / n * angle.cos().matrix().transpose();
    rows.row(2 * i + 1) = 2.0 / n * angle.sin().matrix().transpose();
  }
  return rows;
}

/// Rows that take values at the nodes (on [-1, 1]) to the two highest Legendre coefficients of the polynomial
/// through them (to one, of two nodes).
Eigen::MatrixXd highest_coefficient_rows(const Eigen::VectorXd& nodes) {
  return to_legendre(nodes).bottomRows(std::min<Eigen::Index>(2, nodes.size() - 1));
}

}  // namespace

Eigen::MatrixXd highest_coefficient_rows(const Axis& axis) {
  if (!basis_traits(axis.basis()).tells_resolution) return Eigen::MatrixXd(0, axis.size());
  if (axis.family() == AxisFamily::periodic) return highest_harmonics(axis.size());
  const Eigen::MatrixXd element = highest_coefficient_rows(axis.element_basis().nodes());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(element.rows() * axis.elements(), axis.size());
  for (int e = 0; e < axis.elements(); ++e) {
    rows.block(e * element.rows(), e * axis.degree(), element.rows(), element.cols()) = element;
  }
  return rows;
}

double highest_coefficients(const SeparatedField& field, int axis, std::span<const double> scales,
                            int samples, std::uint64_t seed) {
  const auto own = static_cast<std::size_t>(axis);
  // Sum of both coefficients' sizes per element and term would ignore cancellation between terms: terms are
  // summed first, at sampled nodes of the other axes.
  const Eigen::MatrixXd rows = highest_coefficient_rows(field.axes()[own]);
  if (rows.rows() == 0) return 0.0;
  const Eigen::MatrixXd coefficients = rows * field.factors()[own];
  const Eigen::Index together =
      field.axes()[own].has_elements() ? rows.rows() / field.axes()[own].elements() : rows.rows();
  const Eigen::MatrixXd weights =
      (Eigen::Map<const Eigen::VectorXd>(scales.data(), static_cast<Eigen::Index>(scales.size()))
           .cwiseInverse()
           .asDiagonal() *
       field.weights())
          .transpose();
  Random random(seed);
  Eigen::VectorXd product(field.rank());
  double largest = 0.0;
  for (int i = 0; i < samples; ++i) {
    product.setOnes();
    for (int k = 0; k < field.axis_count(); ++k) {
      const Eigen::MatrixXd& other = field.factors()[static_cast<std::size_t>(k)];
      if (k != axis)
        product.array() *= other.row(random.below(static_cast<int>(other.rows()))).transpose().array();
    }
    const Eigen::MatrixXd outputs = product.asDiagonal() * weights;
    const Eigen::MatrixXd sizes = (coefficients * outputs).cwiseAbs();
    for (Eigen::Index e = 0; e < sizes.rows(); e += together) {
      largest = std::max(largest, sizes.middleRows(e, together).colwise().sum().maxCoeff());
    }
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
