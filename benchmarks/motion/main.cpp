/// Patterns of falling: what the rule is worth on simulations, on drawn paths and on measured drops, and what sweeps
/// cost; motions as segments to go on from; and how near planned falls come to their sketches.
#include <exception>
#include <iostream>

#include "motion/cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    const Options chosen = options(argc, argv);
    motion_cases::run_planar(chosen);
    motion_cases::run_positions(chosen);
    motion_cases::run_measured(chosen);
    motion_cases::run_sweeps(chosen);
    motion_cases::run_sketches(chosen);
    motion_cases::run_books(chosen);
    motion_cases::run_databases(chosen);
    motion_cases::run_walks(chosen);
    motion_cases::run_films(chosen);
  } catch (const std::exception& error) {
    std::cerr << "motion: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
