#pragma once

#include <string>

#include "samara/identification/fit/forecast_comparison.h"

namespace samara::identification {

/// One JSON object with "schema": "samara-compare/1", SI units, null for numbers that are not there. Ends in a newline.
std::string comparison_json(const ModelComparison& comparison);

/// Tables for people: medians and rms of every quantity, their differences with errors, and who loses to a baseline.
std::string comparison_text(const ModelComparison& comparison);

}  // namespace samara::identification
