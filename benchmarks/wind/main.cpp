/// Wind: how far random fields and series are from what they are drawn from, and what a place in them costs.
#include <exception>
#include <iostream>

#include "cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  try {
    const Options chosen = options(argc, argv);
    if (chosen.wants("modes_200")) modes_case(chosen);
    if (chosen.wants("series_iec")) series_case(chosen);
    if (chosen.wants("point")) point_case(chosen);
    if (chosen.wants("meadow_1000")) meadow_case(chosen);
  } catch (const std::exception& error) {
    std::cerr << "wind: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
