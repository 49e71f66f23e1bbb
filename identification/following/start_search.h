#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/following/hypothesis.h"

/// Internal to identification/: where a motion is, from its first frames.
namespace samara::identification {

/// Where the states of a motion have been, each from its lowest to its highest; empty: it was not followed yet.
struct StateRanges {
  Eigen::VectorXd lowest = {}, highest = {};

  void add(const Eigen::VectorXd& point);
};

/// Starts at the state of the first frame, the most likely first; weights are their evidence (Laplace's approximation:
/// likelihood of the frames, times what their errors are narrower than beforehand). Each is the end of a descent of
/// Levenberg and Marquardt from a start of its own: attitudes or angles that are not known begin all around. Starts
/// that ended at the same are one. Model noise is left out of account over these few frames.
/// @param frames of which something is seen
/// @param filter its interval is set
/// @param been of a motion that was lost: what is held or known of its first frame does not count for states that
/// have moved. Those that frames show are left to them, others may be as far from there as they have been.
/// @returns none if no descent had a finite motion
std::vector<Hypothesis> find_starts(const FollowedModel& model, std::span<const SeenFrame> frames,
                                    HypothesisFilter& filter, const StateRanges& been);

}  // namespace samara::identification
