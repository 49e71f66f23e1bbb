/// Bodies and particles in turbulence: whether the process is right, whether realisations repeat, what they cost.
#include <exception>
#include <iostream>

#include "cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    const Options chosen = options(argc, argv);
    run_particles(chosen);
    run_flights(chosen);
  } catch (const std::exception& error) {
    std::cerr << "realise: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
