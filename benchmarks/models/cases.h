#pragma once

#include "report.h"

/// The cases of the benchmark models, by subject; each prints its measurements.
namespace samara::benchmarks {

inline constexpr const char* kModels = "models";

void run_panels(const Options& options);

}  // namespace samara::benchmarks
