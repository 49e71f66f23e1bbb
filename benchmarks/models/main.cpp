/// Bodies, their models and the integrators: how exact, what a step costs, alone and in batches.
#include <exception>
#include <iostream>

#include "cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    const Options chosen = options(argc, argv);
    run_panels(chosen);
    run_steps(chosen);
    run_sweep(chosen);
    run_invariants(chosen);
  } catch (const std::exception& error) {
    std::cerr << "models: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
