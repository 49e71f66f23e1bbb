#pragma once

#include <string>

/// Increasing maps s = T(x) of a coordinate: functions that are hard to represent in x (over decades, or with
/// a root at the end) may be smooth in s.
namespace samara::pgd {

enum class Transform {
  none,         ///< s = x
  logarithm,    ///< s = log x, for x > 0
  reciprocal,   ///< s = -1 / x, for x > 0: the sign only keeps it increasing
  square_root,  ///< s = sqrt x, for x >= 0
};

/// T(x) - T(a). Accurate to rounding however close a and x are.
double transformed_distance(Transform transform, double a, double x);

/// The x with T(x) - T(a) = distance.
double transformed_advance(Transform transform, double a, double distance);

/// dT/dx at x; infinite at the end x = 0 of the square root.
double transform_slope(Transform transform, double x);

/// Whether T and its inverse are defined at x. The square root is defined at 0, where its slope is infinite.
bool in_domain(Transform transform, double x);

/// The names used in files and plans: "none", "log", "reciprocal", "square_root".
std::string to_string(Transform transform);
/// @throws ArgumentError for an unknown name.
Transform transform_from_string(const std::string& name);

}  // namespace samara::pgd
