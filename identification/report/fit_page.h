#pragma once

#include <string>

#include "samara/identification/problem/fit_result.h"

namespace samara::identification {

/// A page for the browser, complete in one file: capture and model over time, residuals, profiles,
/// coefficients with what may be said of them, starts, predictions, captures and warnings. It holds the JSON
/// of the fit (fit_report.h), style, script and the charts' library (uPlot, MIT), loads nothing, and forbids
/// itself the network. What came from files is only ever shown as text.
std::string fit_html(const FitResult& result);

}  // namespace samara::identification
