/// Models of one's own, bodies from meshes, windows that are composed, fields of space, and builds that are cut short.
#include <exception>
#include <iostream>

#include "cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    const Options chosen = options(argc, argv);
    doors::own_model_cases(chosen);
    doors::body_case(chosen);
    doors::windows_case(chosen);
    doors::field_case(chosen);
    doors::interrupts_case(chosen);
  } catch (const std::exception& error) {
    std::cerr << "doors: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
