#pragma once

#include <Eigen/Core>

namespace samara::pgd {

/// Nodes (ascending) and weights of a quadrature rule on [-1, 1].
struct QuadratureRule {
  Eigen::VectorXd nodes;
  Eigen::VectorXd weights;
};

/// Gauss-Legendre rule with n >= 1 nodes, exact for polynomials of degree 2n - 1.
QuadratureRule gauss_legendre(int n);

/// Right Radau rule with n >= 1 nodes, the last of them at +1, exact for polynomials of degree 2n - 2. Its
/// nodes are the collocation points of the Radau IIA methods (Hairer and Wanner, Solving ODEs II, section
/// IV.5).
QuadratureRule gauss_radau_right(int n);

/// Chebyshev-Lobatto nodes cos(pi j / (n - 1)), ascending, n >= 2.
Eigen::VectorXd chebyshev_lobatto_nodes(int n);

/// Gauss-Legendre-Lobatto nodes, ascending, n >= 2: -1, 1 and the zeros of P'_{n-1}.
Eigen::VectorXd legendre_lobatto_nodes(int n);

}  // namespace samara::pgd
