#pragma once

#include <nlohmann/json.hpp>

#include "samara/identification/problem/fit_result.h"
#include "samara/identification/report/diagnostics_report.h"

/// Internal to identification/: how the captures of a fit were seen, in its file.
namespace samara::identification {

Json setup_json(const FitOptions& setup);

/// FitResult::setup from the JSON of a fit; where there is none, as in files of versions that did not write it,
/// from what stands there of coefficients and captures.
/// @param fitted with coefficients and captures
/// @throws nlohmann::json::exception for what is no setup
FitOptions read_setup(const nlohmann::json& fit, const FitResult& fitted);

}  // namespace samara::identification
