#pragma once

#include <string>

namespace samara::identification {

/// How strongly large residuals count. Of a residual r, divided by the loss scale:
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

}  // namespace samara::identification
