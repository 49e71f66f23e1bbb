#include "samara/identification/forecasts/covariant_kernel.h"

#include <cmath>
#include <complex>
#include <initializer_list>
#include <iterator>
#include <limits>

namespace samara::identification {

namespace {

double polynomial(double x, std::initializer_list<double> coefficients) {
  double sum = 0.0;
  for (auto c = std::rbegin(coefficients); c != std::rend(coefficients); ++c) sum = sum * x + *c;
  return sum;
}

/// exp(-x) I_0(x) and exp(-x) I_1(x) of x >= 0, to 3e-7 (Abramowitz and Stegun, Handbook of Mathematical Functions,
/// 1964, 9.8.1 to 9.8.4).
constexpr double kSeries = 3.75;
double scaled_i0(double x) {
  if (x < kSeries) {
    return std::exp(-x) * polynomial(x * x / (kSeries * kSeries),
                                     {1.0, 3.5156229, 3.0899424, 1.2067492, 0.2659732, 0.0360768, 0.0045813});
  }
  return polynomial(kSeries / x, {0.39894228, 0.01328592, 0.00225319, -0.00157565, 0.00916281, -0.02057706,
                                  0.02635537, -0.01647633, 0.00392377}) /
         std::sqrt(x);
}
double scaled_i1(double x) {
  if (x < kSeries) {
    return std::exp(-x) * x *
           polynomial(x * x / (kSeries * kSeries),
                      {0.5, 0.87890594, 0.51498869, 0.15084934, 0.02658733, 0.00301532, 0.00032411});
  }
  return polynomial(kSeries / x, {0.39894228, -0.03988024, -0.00362018, 0.00163801, -0.01031555, 0.02282967,
                                  -0.02895312, 0.01787654, -0.00420059}) /
         std::sqrt(x);
}

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
  return 0.5 * (products.log + size).exp() * size.unaryExpr(&scaled_i0);
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
  return z * (0.5 * (products.log + size).exp() * size.unaryExpr(&scaled_i1) * direction);
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
