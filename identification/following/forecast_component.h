#pragma once

#include <span>
#include <vector>

#include "samara/identification/following/hypothesis.h"
#include "samara/identification/forecasts/forecast.h"

/// Internal to identification/: what one hypothesis says of later frames.
namespace samara::identification {

/// Means and covariances of frames, their noise among them. To second order errors of the state are carried by motions
/// that begin sqrt(3) deviations to either side along each column of a root of their covariance (M. Norgaard, N. K.
/// Poulsen, O. Ravn, Automatica 36 (2000) 1627-1638); exact for a linear motion, as is the first order. Model noise
/// that comes in on the way is carried by derivatives.
/// @param now at `state_time` [s]
/// @param times s, of frames; not decreasing, the first not before that of the state and its lead
ForecastComponent forecast_component(const FollowedModel& model, HypothesisFilter& filter,
                                     const Hypothesis& now, double state_time, std::span<const double> times,
                                     const std::vector<SeenOutput>& outputs);

}  // namespace samara::identification
