#pragma once

#include <string>

#include "samara/identification/series/coefficient_series.h"

namespace samara::identification {

/// One JSON object with "schema": "samara-series/1": the series, then the fit as fit_json(). Ends in a
/// newline.
std::string series_json(const CoefficientSeries& series);

/// A table for people.
std::string series_text(const CoefficientSeries& series);

}  // namespace samara::identification
