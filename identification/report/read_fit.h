#pragma once

#include <filesystem>

#include "samara/identification/problem/fit_result.h"

namespace samara::identification {

/// What another fit may take over from the file that fit_json() made: status, message, model, what was
/// held, coefficients with their errors, noise levels, and the names of the captures. Nothing else.
/// @throws InputError if the file is none of a fit.
FitResult read_fit(const std::filesystem::path& path);

}  // namespace samara::identification
