#pragma once

#include <vector>

#include "report.h"

/// The cases of the benchmark query; each prints its measurements.
namespace samara::benchmarks {

inline constexpr const char* kQuery = "query";

void run_plates(const Options& options);
void run_body(const Options& options);
void run_trains(const Options& options);
void run_files(const Options& options);

/// Seconds of the machine's fastest product at hand of a rows x inner and an inner x columns matrix.
double gemm_seconds(int rows, int inner, int columns, bool single);

/// The plainest loops that evaluate a train with one output: cores row by row (left, node, right), nodes of
/// [-1, 1] with barycentric weights; written once more in a file that is compiled for the machine.
struct PlainTrain {
  std::vector<std::vector<double>> cores;
  std::vector<int> ranks;  ///< 1, r, .., 1
  std::vector<double> nodes, barycentric;
};
double plain_value(const PlainTrain& train, const double* x);
double plain_value_native(const PlainTrain& train, const double* x);

}  // namespace samara::benchmarks
