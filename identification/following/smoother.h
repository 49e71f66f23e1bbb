#pragma once

#include <span>
#include <vector>

#include "samara/identification/following/follower.h"
#include "samara/identification/following/hypothesis.h"

/// Internal to identification/: the past of a hypothesis in the light of what followed.
namespace samara::identification {

/// States at the times of the records, by the smoother of Rauch, Tung and Striebel.
std::vector<FollowedState> smooth(const FollowedModel& model, const std::vector<FrameRecord>& records);

/// Records of the frames from which a start was found: the motion of the start through them, which knows all of them.
/// @param start at the first of the frames, less `lead` [s]
std::vector<FrameRecord> start_records(const FollowedModel& model, const Hypothesis& start,
                                       std::span<const SeenFrame> frames, double lead);

/// The model noise over these frames comes in with the last of them, at which the hypothesis now stands.
void end_start_records(Hypothesis& hypothesis);

}  // namespace samara::identification
