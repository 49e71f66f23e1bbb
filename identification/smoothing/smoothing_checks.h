#pragma once

#include "samara/identification/smoothing/local_polynomial.h"
#include "samara/identification/smoothing/smoothing.h"

/// What the smoothings have in common; internal to identification/.
namespace samara::identification {

/// The frames of a record in which something is seen, as the local fits of a smoothing use them.
/// @param seen their numbers, in order
LocalFrames seen_frames(const Eigen::VectorXd& times, const std::vector<Eigen::Index>& seen,
                        const SmoothingOptions& options);

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
