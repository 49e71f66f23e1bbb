#include "samara/identification/forecasts/covariant_kernel.h"

#include <cmath>
#include <complex>
#include <limits>

#include <unsupported/Eigen/SpecialFunctions>

namespace samara::identification {

namespace {

/// Of moments and centres: z as they are seen and with the centres mirrored, and the logarithm of the Gaussian kernel
/// less the real part of z.
struct Products {
  Eigen::ArrayXXcd z = {}, mirrored = {};
  Eigen::ArrayXXd log = {};
  Eigen::ArrayXXd log_exchanged = {};  ///< the views of the centres exchanged; empty without views
};

Products products_of(const TurningRows& moments, const TurningRows& centres) {
  const auto squares = [](const TurningRows& rows) -> Eigen::VectorXd {
    return rows.level.rowwise().squaredNorm() + rows.others.rowwise().squaredNorm() +
           rows.views.rowwise().squaredNorm();
  };
  Eigen::MatrixXd logs = moments.others * centres.others.transpose();
  logs.colwise() -= 0.5 * squares(moments);
  logs.rowwise() -= 0.5 * squares(centres).transpose();
  Products products{.z = moments.level * centres.level.adjoint(),
                    .mirrored = moments.level * centres.level.transpose(),
                    .log = logs};
  if (moments.views.cols() == 0) return products;
  products.log += (moments.views * centres.views.adjoint()).real().array();
  products.log_exchanged = logs.array() + (moments.views * centres.views.transpose()).imag().array();
  return products;
}

/// The Gaussian kernel with centres turned by quarters.
struct QuarterTurns {
  Eigen::ArrayXXd none, one, two, three;
};
QuarterTurns quarter_turns(const Products& products, const Eigen::ArrayXXcd& z) {
  const Eigen::ArrayXXd along = z.real(), across = z.imag();
  return {(products.log + along).exp(), (products.log_exchanged + across).exp(), (products.log - along).exp(),
          (products.log_exchanged - across).exp()};
}

/// k_0/2 and k_1/2.
Eigen::ArrayXXd half_still(const Products& products, const Eigen::ArrayXXcd& z) {
  if (products.log_exchanged.size() > 0) {
    const QuarterTurns turned = quarter_turns(products, z);
    return 0.125 * (turned.none + turned.one + turned.two + turned.three);
  }
  const Eigen::ArrayXXd size = z.abs2().sqrt();
  return 0.5 * (products.log + size).exp() * Eigen::bessel_i0e(size);
}
Eigen::ArrayXXcd half_turning(const Products& products, const Eigen::ArrayXXcd& z) {
  if (products.log_exchanged.size() > 0) {
    const QuarterTurns turned = quarter_turns(products, z);
    Eigen::ArrayXXcd kernel(z.rows(), z.cols());
    kernel.real() = 0.125 * (turned.none - turned.two);
    kernel.imag() = 0.125 * (turned.one - turned.three);
    return kernel;
  }
  const Eigen::ArrayXXd size = z.abs2().sqrt(),
                        direction = size.max(std::numeric_limits<double>::min()).inverse();
  return z * (0.5 * (products.log + size).exp() * Eigen::bessel_i1e(size) * direction);
}

}  // namespace

Eigen::MatrixXd still_kernel(const TurningRows& moments, const TurningRows& centres) {
  const Products products = products_of(moments, centres);
  return half_still(products, products.z) + half_still(products, products.mirrored);
}

TurningKernel turning_kernel(const TurningRows& moments, const TurningRows& centres) {
  const Products products = products_of(moments, centres);
  return {half_turning(products, products.z), half_turning(products, products.mirrored)};
}

}  // namespace samara::identification
