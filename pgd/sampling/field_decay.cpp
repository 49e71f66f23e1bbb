#include "samara/pgd/sampling/field_decay.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace samara::pgd {

namespace {

/// Rows: weights of the values at `size` Chebyshev-Lobatto points, ascending, in the last two coefficients
/// (cosine sums with halved ends).
Eigen::MatrixXd last_coefficients(int size) {
  const int n = size - 1;
  const int rows = std::min(2, size);
  const auto half_at_ends = [n](int i) { return i == 0 || i == n ? 0.5 : 1.0; };
  Eigen::MatrixXd weights(rows, size);
  for (int r = 0; r < rows; ++r) {
    const int j = size - rows + r;
    for (int i = 0; i < size; ++i) {
      const double angle = std::numbers::pi * (n - i) / n;
      weights(r, i) = 2.0 / n * half_at_ends(i) * half_at_ends(j) * std::cos(j * angle);
    }
  }
  return weights;
}

}  // namespace

std::vector<double> coefficient_tails(const TrainField& field, const Eigen::VectorXd& scale,
                                      const Eigen::MatrixXd& points) {
  TrainField::Workspace workspace = field.make_workspace();
  Eigen::VectorXd values(field.output_count());
  std::vector<double> tails;
  for (Eigen::Index k = 0; k < points.rows(); ++k) {
    const Axis& axis = field.axes()[static_cast<std::size_t>(k)];
    const Eigen::MatrixXd weights = last_coefficients(axis.size());
    double sum = 0.0;
    for (Eigen::Index line = 0; line < points.cols(); ++line) {
      Eigen::VectorXd x = points.col(line);
      Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(field.output_count(), weights.rows());
      for (int i = 0; i < axis.size(); ++i) {
        x[k] = axis.nodes()[i];
        field.evaluate({x.data(), static_cast<std::size_t>(x.size())}, values, workspace);
        coefficients += values * weights.col(i).transpose();
      }
      sum += (scale.cwiseInverse().asDiagonal() * coefficients).rowwise().squaredNorm().maxCoeff();
    }
    tails.push_back(std::sqrt(sum / static_cast<double>(points.cols())));
  }
  return tails;
}

}  // namespace samara::pgd
