#pragma once

#include "report.h"

/// The cases of the benchmark models, by subject; each prints its measurements.
namespace samara::benchmarks {

inline constexpr const char* kModels = "models";

void run_panels(const Options& options);
void run_steps(const Options& options);
void run_sweep(const Options& options);
void run_invariants(const Options& options);

}  // namespace samara::benchmarks
