#pragma once

#include "report.h"

/// The cases of the benchmark "doors".
namespace samara::benchmarks::doors {

inline constexpr const char* kBench = "doors";

void own_model_cases(const Options& options);
void body_case(const Options& options);
void windows_case(const Options& options);
void field_case(const Options& options);
void interrupts_case(const Options& options);

}  // namespace samara::benchmarks::doors
