#pragma once

#include <Eigen/Core>

namespace samara::pgd {

/// Lagrange interpolation on given distinct nodes, by barycentric weights.
/// Reference: Berrut and Trefethen, Barycentric Lagrange interpolation, SIAM Review 46 (2004), (4.2), (9.4),
/// (9.5).
class LagrangeBasis {
 public:
  explicit LagrangeBasis(Eigen::VectorXd nodes);

  int size() const { return static_cast<int>(nodes_.size()); }
  const Eigen::VectorXd& nodes() const { return nodes_; }

  /// Values l_j(x) of all basis polynomials. Size of `values`: size(). Does not allocate.
  void values(double x, Eigen::Ref<Eigen::VectorXd> values) const;

  /// D_ij = l_j'(node i).
  const Eigen::MatrixXd& differentiation() const { return differentiation_; }

 private:
  Eigen::VectorXd nodes_;
  Eigen::VectorXd barycentric_;
  Eigen::MatrixXd differentiation_;
};

}  // namespace samara::pgd
