/// Separated solutions of strongly nonlinear equations, computed a priori: errors against an independent
/// integrator at random points off the grid, ranks, evaluations and times.
#include <exception>
#include <iostream>

#include "cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    const Options chosen = options(argc, argv);
    run_plans(chosen);
    run_products(chosen);
    run_kirchhoff7(chosen);
    run_plates(chosen);
    run_piecewise_linear(chosen);
    run_strategies(chosen);
    run_strategy_orders(chosen);
    run_bodies(chosen);
    run_builders(chosen);
  } catch (const std::exception& error) {
    std::cerr << "nonlinear: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
