#pragma once

#include <Eigen/Core>

namespace samara::pgd {

/// Thin QR factorisation: returns Q (rows x k), sets R (k x columns), k the smaller of rows and columns.
Eigen::MatrixXd thin_qr(const Eigen::MatrixXd& matrix, Eigen::MatrixXd& r);
/// R alone, at a third of the cost.
Eigen::MatrixXd qr_factor(const Eigen::MatrixXd& matrix);

}  // namespace samara::pgd
