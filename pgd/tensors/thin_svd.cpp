#include "samara/pgd/tensors/thin_svd.h"

#include <Eigen/SVD>

namespace samara::pgd {

ThinSvd thin_svd(const Eigen::MatrixXd& matrix) {
  constexpr unsigned kThin = Eigen::ComputeThinU | Eigen::ComputeThinV;
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(matrix, kThin);
  ThinSvd result{svd.matrixU(), svd.singularValues(), svd.matrixV()};
  if (result.u.allFinite() && result.singular.allFinite() && result.v.allFinite()) return result;
  // Divide and conquer of Eigen 3.4 gives NaN, and reports success, for some matrices with columns of round-off.
  const Eigen::JacobiSVD<Eigen::MatrixXd> slow(matrix, kThin);
  return {slow.matrixU(), slow.singularValues(), slow.matrixV()};
}

}  // namespace samara::pgd
