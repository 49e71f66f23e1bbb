#pragma once

#include "report.h"

/// The cases of the benchmark flow, by subject; each prints its measurements. Those that take more than
/// five minutes run only by their name.
namespace samara::benchmarks {

inline constexpr const char* kFlow = "flow";

void run_laminar(const Options& options);
void run_channels(const Options& options);
/// square_22000 and plate_90, which keep their state in files of the working folder and go on from there.
void run_bluff_bodies(const Options& options);
void run_costs(const Options& options);
/// energy_book, which keeps its flows in a file of the working folder.
void run_energy_book(const Options& options);

}  // namespace samara::benchmarks
