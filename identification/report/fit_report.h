#pragma once

#include <string>

#include "samara/identification/problem/fit_result.h"

namespace samara::identification {

/// One JSON object with "schema": "samara-fit/1": everything in the result, SI units, null for numbers that
/// are not there. Ends in a newline.
std::string fit_json(const FitResult& result);

/// Tables for people.
std::string fit_text(const FitResult& result);

}  // namespace samara::identification
