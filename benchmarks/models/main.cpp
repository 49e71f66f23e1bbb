/// Bodies and their models: how exact, and what they cost.
#include <exception>
#include <iostream>

#include "cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    const Options chosen = options(argc, argv);
    run_panels(chosen);
  } catch (const std::exception& error) {
    std::cerr << "models: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
