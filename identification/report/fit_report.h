#pragma once

#include <filesystem>
#include <string>

#include "samara/identification/problem/fit_result.h"

namespace samara::identification {

/// One JSON object with "schema": "samara-fit/1": everything in the result, SI units, null for numbers that
/// are not there. Ends in a newline.
std::string fit_json(const FitResult& result);

/// Tables for people.
std::string fit_text(const FitResult& result);

/// What another fit may take over from the file that fit_json() made: status, message, model, coefficients
/// with their errors, noise levels, and the names of the captures. Nothing else.
/// @throws InputError if the file is none of a fit.
FitResult read_fit(const std::filesystem::path& path);

}  // namespace samara::identification
