#pragma once

#include "samara/identification/fit_options.h"
#include "samara/identification/fit_result.h"

/// Internal to identification/.
namespace samara::identification {

/// Puts the loss scales of the noise levels with which a fit ended in place of levels to be found.
void hold_noise(const FitResult& fitted, FitOptions& options);

}  // namespace samara::identification
