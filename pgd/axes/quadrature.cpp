#include "samara/pgd/axes/quadrature.h"

#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "samara/base/errors.h"

namespace samara::pgd {

namespace {

/// Golub and Welsch (1969): the nodes are the eigenvalues of the Jacobi matrix of the recurrence, the weights
/// the squared first components of its eigenvectors times the integral of 1.
QuadratureRule from_jacobi_matrix(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& off_diagonal) {
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
  eigen.computeFromTridiagonal(diagonal, off_diagonal);
  return {eigen.eigenvalues(), 2.0 * eigen.eigenvectors().row(0).transpose().array().square().matrix()};
}

/// Recurrence coefficients sqrt(beta_k) of the Legendre polynomials, k = 1..n-1.
Eigen::VectorXd legendre_off_diagonal(int n) {
  Eigen::VectorXd b(n - 1);
  for (int k = 1; k < n; ++k) b[k - 1] = k / std::sqrt(4.0 * k * k - 1.0);
  return b;
}

void require_at_least(int n, int least) {
  if (n < least) {
    throw ArgumentError("number of quadrature nodes is " + std::to_string(n) + ", expected at least " +
                        std::to_string(least));
  }
}

}  // namespace

QuadratureRule gauss_legendre(int n) {
  require_at_least(n, 1);
  return from_jacobi_matrix(Eigen::VectorXd::Zero(n), legendre_off_diagonal(n));
}

QuadratureRule gauss_radau_right(int n) {
  require_at_least(n, 1);
  // Golub (1973): the last diagonal entry becomes 1 - beta_{n-1} p_{n-2}(1) / p_{n-1}(1), with the monic
  // Legendre polynomials p, so that +1 is an eigenvalue.
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(n);
  double ratio = 0.0;  // p_{k-1}(1) / p_k(1)
  for (int k = 0; k + 1 < n; ++k) {
    const double beta = k == 0 ? 0.0 : k * k / (4.0 * k * k - 1.0);
    ratio = 1.0 / (1.0 - beta * ratio);
  }
  const double m = n - 1;
  const double beta_last = n == 1 ? 0.0 : m * m / (4.0 * m * m - 1.0);
  diagonal[n - 1] = 1.0 - beta_last * ratio;
  QuadratureRule rule = from_jacobi_matrix(diagonal, legendre_off_diagonal(n));
  rule.nodes[n - 1] = 1.0;
  return rule;
}

Eigen::VectorXd chebyshev_lobatto_nodes(int n) {
  require_at_least(n, 2);
  Eigen::VectorXd nodes(n);
  // The sine form is antisymmetric in floating point and hits -1, 0 and 1 exactly.
  for (int j = 0; j < n; ++j) nodes[j] = std::sin(0.5 * std::numbers::pi * (2.0 * j - (n - 1)) / (n - 1));
  return nodes;
}

Eigen::VectorXd legendre_lobatto_nodes(int n) {
  require_at_least(n, 2);
  Eigen::VectorXd nodes(n);
  nodes[0] = -1.0;
  nodes[n - 1] = 1.0;
  if (n == 2) return nodes;
  // P'_{n-1} is the Jacobi polynomial P^(1,1)_{n-2} but for a factor; beta_k = k (k + 2) / ((2k + 1)(2k +
  // 3)).
  Eigen::VectorXd b(n - 3);
  for (int k = 1; k + 2 < n; ++k) b[k - 1] = std::sqrt(k * (k + 2.0) / ((2.0 * k + 1.0) * (2.0 * k + 3.0)));
  const Eigen::VectorXd zeros = from_jacobi_matrix(Eigen::VectorXd::Zero(n - 2), b).nodes;
  nodes.segment(1, n - 2) = 0.5 * (zeros - zeros.reverse());  // antisymmetric, 0 exactly
  return nodes;
}

}  // namespace samara::pgd
