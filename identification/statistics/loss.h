#pragma once

#include <string>

namespace samara::identification {

/// How strongly large residuals count. Of a residual r, divided by the loss scale. A new one needs a line or a
/// case in every function of loss.cpp:
enum class LossKind {
  none,     ///< rho = r^2
  huber,    ///< rho = r^2 up to |r| = 1, then 2 |r| - 1: convex, outliers pull with a constant force
  soft_l1,  ///< rho = 2 (sqrt(1 + r^2) - 1): a smooth huber
  cauchy,   ///< rho = log(1 + r^2): far outliers hardly count; several optima are possible
};

/// The names used in files: "none", "huber", "soft_l1", "cauchy".
std::string to_string(LossKind kind);
/// @throws ArgumentError naming the nearest.
LossKind loss_kind_from_string(const std::string& name);

struct LossValue {
  double rho = 0.0;   ///< r^2 for small r
  double psi = 0.0;   ///< half the derivative of rho: r for small r
  double dpsi = 0.0;  ///< derivative of psi: 1 for small r
};

LossValue loss_value(LossKind kind, double r);

/// The loss scale over the standard deviation of normal noise at which estimates of location keep 95 % of the
/// efficiency of least squares; 1 where there is no bend.
double efficient_bend(LossKind kind);

/// Whether exp(-rho/(2 f^2)) is a density of noise for every f, with tails that fall exponentially or faster: what
/// evidence is of.
bool is_density(LossKind kind);

/// What a scale is estimated with: r^2 for small r, monotonous in |r|, bounded for robust losses.
double bounded_loss(LossKind kind, double r);

/// The mean of bounded_loss(kind, Z / efficient_bend(kind)) for normal Z.
double expected_bounded_loss(LossKind kind);

}  // namespace samara::identification
