#include "samara/pgd/axes/lagrange.h"

#include <utility>

namespace samara::pgd {

LagrangeBasis::LagrangeBasis(Eigen::VectorXd nodes) : nodes_(std::move(nodes)) {
  const Eigen::Index n = nodes_.size();
  barycentric_ = Eigen::VectorXd::Ones(n);
  // Differences are doubled to keep the products of many nodes on [-1, 1] (capacity 1/2) near one.
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index k = 0; k < n; ++k) {
      if (k != j) barycentric_[j] /= 2.0 * (nodes_[j] - nodes_[k]);
    }
  }
  differentiation_ = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      if (j == i) continue;
      differentiation_(i, j) = barycentric_[j] / barycentric_[i] / (nodes_[i] - nodes_[j]);
      // The derivative of a constant is zero: the negative sum is more accurate than the formula.
      differentiation_(i, i) -= differentiation_(i, j);
    }
  }
}

void LagrangeBasis::values(double x, Eigen::Ref<Eigen::VectorXd> values) const {
  double sum = 0.0;
  for (Eigen::Index j = 0; j < nodes_.size(); ++j) {
    const double difference = x - nodes_[j];
    if (difference == 0.0) {
      values.setZero();
      values[j] = 1.0;
      return;
    }
    values[j] = barycentric_[j] / difference;
    sum += values[j];
  }
  values /= sum;
}

}  // namespace samara::pgd
