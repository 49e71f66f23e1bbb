/// Answers of codebooks against the best that one writes without them, in the same process, writing the same
/// numbers: points, trajectories, batches, residuals with derivatives; size; opening; damaged files.
#include <exception>
#include <iostream>

#include "cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    const Options chosen = options(argc, argv);
    run_plates(chosen);
    run_body(chosen);
    run_trains(chosen);
    run_files(chosen);
  } catch (const std::exception& error) {
    std::cerr << "query: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
