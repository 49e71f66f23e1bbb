#pragma once

#include "report.h"

/// The cases of the benchmark linear_engine, by subject; each prints its measurements.
namespace samara::benchmarks {

inline constexpr const char* kLinearEngine = "linear_engine";

void run_poisson(const Options& options);
void run_published(const Options& options);
void run_moving_load(const Options& options);
void run_heat(const Options& options);
void run_mesh(const Options& options);
void run_costs(const Options& options);
/// What the process of --memory does: solves, and prints its peak memory in kilobytes.
void solve_for_memory(int nodes);
void run_solvers(const Options& options);
void run_solver_sizes(const Options& options);
void run_sobol(const Options& options);

}  // namespace samara::benchmarks
