#include "samara/pgd/tensors/thin_qr.h"

#include <algorithm>

#include <Eigen/QR>

namespace samara::pgd {

Eigen::MatrixXd thin_qr(const Eigen::MatrixXd& matrix, Eigen::MatrixXd& r) {
  const Eigen::Index k = std::min(matrix.rows(), matrix.cols());
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(matrix);
  r = qr.matrixQR().topRows(k).triangularView<Eigen::Upper>();
  return qr.householderQ() * Eigen::MatrixXd::Identity(matrix.rows(), k);
}

Eigen::MatrixXd qr_factor(const Eigen::MatrixXd& matrix) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(matrix);
  return qr.matrixQR().topRows(std::min(matrix.rows(), matrix.cols())).triangularView<Eigen::Upper>();
}

}  // namespace samara::pgd
