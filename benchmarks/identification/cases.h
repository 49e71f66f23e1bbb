#pragma once

#include "report.h"

/// The cases of the benchmark `identification`, one file each.
namespace samara::benchmarks::identification {

inline constexpr const char* kBench = "identification";

void coin_cases(const Options& options);
void plate_cases(const Options& options);
void posterior_case(const Options& options);
void design_case(const Options& options);
void body_cases(const Options& options);
void segment_map_case(const Options& options);
void table_tennis_case(const Options& options);
void blimp_case(const Options& options);
void falling_paper_case(const Options& options);
void settling_plates_case(const Options& options);
void april_paper_case(const Options& options);

}  // namespace samara::benchmarks::identification
