#pragma once

#include <optional>

#include <Eigen/Core>

/// What a falling plate does on the average. Where a motion forgets its start, a fit of trajectories alone
/// may meet every short span and still fall too slowly in the long run.
namespace samara::identification {

struct Flutter {
  double fall_speed = 0.0;  ///< m/s, of the straight line through the heights
  double frequency = 0.0;   ///< Hz, of the strongest horizontal oscillation
  double amplitude = 0.0;   ///< m, the larger semi-axis of the ellipse that it draws
};

/// From a part of a fall that is long beside a swing; the drift taken out is a parabola.
///
/// The frequency is where sines fitted to both horizontal coordinates by least squares explain most, between
/// 1.5 swings in the record and a quarter of the frame rate, found to 1e-4 of itself.
/// @param times s, increasing
/// @param positions frames x (x, y, z), m, z up; frames with NaN are left out
/// @returns nothing for fewer than 12 frames
/// @throws ArgumentError for sizes that differ, and times that are not finite or do not increase.
std::optional<Flutter> flutter(const Eigen::VectorXd& times, const Eigen::MatrixX3d& positions);

/// Medians over parts of so many seconds, one after the other.
/// @returns nothing if no part has enough frames
/// @throws ArgumentError as flutter(), and for a part that is not positive
std::optional<Flutter> typical_flutter(const Eigen::VectorXd& times, const Eigen::MatrixX3d& positions,
                                       double part);

}  // namespace samara::identification
