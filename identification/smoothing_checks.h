#pragma once

#include "samara/identification/smoothing.h"

/// What the smoothings have in common; internal to identification/.
namespace samara::identification {

/// Width of the window, s.
double window_of(const Eigen::VectorXd& times, const SmoothingOptions& options);

/// @throws ArgumentError if there is not one time for each row, or times do not increase
void check_times(const Eigen::VectorXd& times, Eigen::Index rows);

/// @throws ArgumentError as smooth(), but for the seen frames
void check_smoothing(const Eigen::VectorXd& times, Eigen::Index rows, const Eigen::VectorXd& at,
                     const SmoothingOptions& options);

/// So many frames a channel must be seen in.
inline Eigen::Index least_frames(int degree) {
  return degree + 2;
}

/// @throws ArgumentError if they are too few
void check_seen_frames(Eigen::Index count, const SmoothingOptions& options);

}  // namespace samara::identification
