/// The sampling builder: errors against distinct calls, and whether its claims hold.
#include <exception>
#include <iostream>

#include "cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    const Options chosen = options(argc, argv);
    run_functions(chosen);
    run_codebooks(chosen);
    run_guard(chosen);
    run_lorenz(chosen);
    run_persistent_command(chosen);
  } catch (const std::exception& error) {
    std::cerr << "sampling: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
