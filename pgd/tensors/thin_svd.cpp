#include "samara/pgd/tensors/thin_svd.h"

#include <Eigen/SVD>

namespace samara::pgd {

ThinSvd thin_svd(const Eigen::MatrixXd& matrix) {
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

}  // namespace samara::pgd
