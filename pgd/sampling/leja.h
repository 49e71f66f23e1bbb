#pragma once

#include <Eigen/Core>

namespace samara::pgd {

/// The first `count` points of a Leja sequence on [-1, 1]: 1, -1, 0, and then always the point at which the
/// product of the distances to all earlier ones is largest (of two equal ones the positive first).
///
/// A longer sequence begins with the shorter one, so that a grid grows without losing values already known,
/// and interpolation on the points is nearly as well conditioned as on Chebyshev's. Reference: L. Reichel,
/// Newton interpolation at Leja points, BIT 30 (1990), 332-346.
/// @throws ArgumentError if count is not in 1 .. kMostLejaPoints.
Eigen::VectorXd leja_points(int count);

inline constexpr int kMostLejaPoints = 128;

}  // namespace samara::pgd
