#pragma once

#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_result.h"

/// Internal to identification/.
namespace samara::identification {

/// The loss scales that a fit ended with, in place of noise levels to be found: for fits whose costs or
/// errors are to be compared with its own.
void hold_noise(const FitResult& fitted, FitOptions& options);

}  // namespace samara::identification
