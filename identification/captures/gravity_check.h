#pragma once

#include <span>
#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/models/interface/parametric_model.h"

/// Whether captures look as if one of their axes pointed the other way.
///
/// A body that nothing drives may rise only as long as it is slowed: its weight and its drag act downward
/// then. One that rises for a good part of what was seen, and keeps its speed or gains some, has its weight
/// elsewhere than the model.
namespace samara::identification {

/// Whether a body of the model falls or rises when it is let go: at rest it accelerates by 0.5 m/s^2 or more,
/// or the model does not say where it is.
bool falls(const models::ParametricModel& equations, std::span<const double> q);

/// Warnings, one sentence each, as of suspicions_of_all(). None where the body has hardly a weight (at rest
/// it accelerates by less than 0.5 m/s^2), where what moves it changes with the place along it or with time, or where
/// positions along it were not measured.
/// @param equations with the coordinates of a fit free
/// @param q their values: the middle of the box does
std::vector<std::string> check_gravity(const models::ParametricModel& equations, std::span<const double> q,
                                       std::span<const Capture> captures);

}  // namespace samara::identification
