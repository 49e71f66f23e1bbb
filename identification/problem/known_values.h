#pragma once

#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Coordinates that captures say themselves; internal to identification/.
namespace samara::identification {

/// The value of a known coordinate, SI.
/// @throws ArgumentError or InputError if the capture does not say it
double known_value(const Capture& capture, const std::string& coordinate, const KnownValue& known);

/// Values of UnknownOptions::known, in its order.
/// @throws ArgumentError or InputError as above, and for values outside the family's box
std::vector<double> known_values(const models::FamilyInfo& family, const Capture& capture,
                                 const FitOptions& options);

/// Whether the capture says what a known coordinate is.
bool has_value(const Capture& capture, const KnownValue& known);

}  // namespace samara::identification
