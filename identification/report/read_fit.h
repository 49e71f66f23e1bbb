#pragma once

#include <filesystem>

#include "samara/identification/problem/fit_result.h"

namespace samara::identification {

/// What another fit, or the design of the next experiment, may take over from the file that fit_json() made:
/// status, message, model, what was held, how captures were seen, coefficients with their errors and
/// covariances, residuals and noise levels, whether residuals are white (without their series), and of the
/// captures their names, times, and what is their own. Nothing else.
/// @throws InputError if the file is none of a fit.
FitResult read_fit(const std::filesystem::path& path);

}  // namespace samara::identification
