#pragma once

#include <algorithm>
#include <cmath>

#include "samara/models/interface/model.h"

namespace samara::models::laws {

constexpr double kStandardGravity = 9.80665;  ///< [m/s^2]

/// Drag coefficients below this, which no body in a fluid has, leave the scales as they are.
constexpr double kLeastDragCoefficient = 0.01;

/// Characteristic sizes of  v' = a - k |v| v : the terminal speed sqrt(a/k), the time sqrt(1/(a k)) and the
/// way 1/k on which it is approached.
///
/// Without drag (k = 0) there is no terminal speed, without drive (a = 0) no motion from rest; yet tolerances
/// need finite sizes. So `k` is taken as no less than `least_k`, and the drive as no less than a thousandth
/// of standard gravity: the sizes stay continuous in the parameters, and are exact in every case of interest.
/// @param drive a [m/s^2], either sign  @param k, least_k [1/m], least_k > 0
inline Scales drag_scales(double drive, double k, double least_k) {
  constexpr double kLeastDrive = 1e-3 * kStandardGravity;
  const double a = std::max(std::abs(drive), kLeastDrive);
  const double drag = std::max(k, least_k);
  return {.length = 1.0 / drag, .time = 1.0 / std::sqrt(a * drag), .velocity = std::sqrt(a / drag)};
}

}  // namespace samara::models::laws
