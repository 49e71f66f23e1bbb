#pragma once

#include "report.h"

/// The cases of the benchmark `prediction`, one file each: what follows of motions that no fit has seen.
namespace samara::benchmarks::prediction {

inline constexpr const char* kBench = "prediction";

void paper_cases(const Options& options);
void plates_cases(const Options& options);
void blimp_cases(const Options& options);
void table_tennis_case(const Options& options);
void follow_case(const Options& options);

}  // namespace samara::benchmarks::prediction
