#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/following/hypothesis.h"

/// Internal to identification/: where a motion is, from its first frames.
namespace samara::identification {

/// Starts at the state of the first frame, the most likely first; weights are their evidence (Laplace's approximation:
/// likelihood of the frames, times what their errors are narrower than beforehand). Each is the end of a descent of
/// Levenberg and Marquardt from a start of its own: attitudes or angles that are not known begin all around. Starts
/// that ended at the same are one. Model noise is left out of account over these few frames.
/// @param frames of which something is seen
/// @param filter its interval is set
/// @returns none if no descent had a finite motion
std::vector<Hypothesis> find_starts(const FollowedModel& model, std::span<const SeenFrame> frames,
                                    HypothesisFilter& filter);

/// The values, and the rates, that parabolas (lines, if there are few frames) through the frames give the states that
/// are measured, at the first frame; NaN for others.
struct MeasuredStates {
  Eigen::VectorXd values, rates, rate_errors;
};
MeasuredStates measured_states(const FollowedModel& model, std::span<const SeenFrame> frames);

}  // namespace samara::identification
