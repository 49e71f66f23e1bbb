/// The linear engine on problems with known answers: ranks against errors, projections against the optimum,
/// and what a term costs.
#include <exception>
#include <iostream>
#include <string>
#include <string_view>

#include "cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    if (argc == 3 && std::string_view(argv[1]) == "--memory") {
      solve_for_memory(std::stoi(argv[2]));
      return 0;
    }
    const Options chosen = options(argc, argv);
    run_poisson(chosen);
    run_published(chosen);
    run_moving_load(chosen);
    run_heat(chosen);
    run_mesh(chosen);
    run_costs(chosen);
    run_solvers(chosen);
    run_solver_sizes(chosen);
    run_sobol(chosen);
  } catch (const std::exception& error) {
    std::cerr << "linear_engine: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
