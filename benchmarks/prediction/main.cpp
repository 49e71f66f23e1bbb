/// How well the next moments of motions left out are forecast, as distributions, beside plain baselines.
#include <iostream>

#include <glog/logging.h>

#include "cases.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  FLAGS_minloglevel = google::GLOG_FATAL;
  try {
    const Options chosen = options(argc, argv);
    prediction::paper_cases(chosen);
    prediction::plates_cases(chosen);
    prediction::blimp_cases(chosen);
    prediction::table_tennis_case(chosen);
    prediction::follow_case(chosen);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
