/// The flow solver on flows with known answers, and what a step costs.
#include <exception>
#include <iostream>

#include "cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    const Options chosen = options(argc, argv);
    run_laminar(chosen);
    run_channels(chosen);
    run_costs(chosen);
    run_bluff_bodies(chosen);
    run_energy_book(chosen);
  } catch (const std::exception& error) {
    std::cerr << "flow: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
