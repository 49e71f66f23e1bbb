#pragma once

#include <span>

#include <Eigen/Core>

#include "samara/identification/following/hypothesis.h"

/// Internal to identification/: what first frames say of single states.
namespace samara::identification {

/// The values, and the rates, that parabolas (lines, if there are few frames) through the frames give the states that
/// are measured, at the first frame; NaN for others.
struct MeasuredStates {
  Eigen::VectorXd values, rates, rate_errors;
};
MeasuredStates measured_states(const FollowedModel& model, std::span<const SeenFrame> frames);

}  // namespace samara::identification
