#pragma once

#include <Eigen/Core>

namespace samara::pgd {

/// Thin singular value decomposition, matrix = U diag(singular) V^T, singular values falling.
struct ThinSvd {
  Eigen::MatrixXd u;
  Eigen::VectorXd singular;
  Eigen::MatrixXd v;
};
/// In a source of its own: the compiler takes as long for Eigen's as for the rest of a file.
ThinSvd thin_svd(const Eigen::MatrixXd& matrix);

}  // namespace samara::pgd
