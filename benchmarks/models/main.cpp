/// The models and their integrators: what a step costs, alone and in batches, and what is conserved.
#include <exception>
#include <iostream>

#include "cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    const Options chosen = options(argc, argv);
    run_steps(chosen);
    run_sweep(chosen);
    run_invariants(chosen);
  } catch (const std::exception& error) {
    std::cerr << "models: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
