#pragma once

#include <span>
#include <string>

#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/fit_options.h"

/// Internal to identification/: the scales of residuals before their noise has been estimated.
namespace samara::identification {

/// Whether the options ask for the noise of this output, or of "attitude".
bool noise_is_estimated(const NoiseOptions& options, const std::string& output);

/// The median over captures of the scatter of an output's frames about a smooth curve; where no capture has
/// enough of them, a thousandth of its spread.
double frame_scatter(std::span<const Capture> captures, const std::string& output, double period);

}  // namespace samara::identification
