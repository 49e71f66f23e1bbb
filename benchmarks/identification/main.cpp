/// Coefficients from captures: synthetic ones, whose truth is known, and real ones.
#include <iostream>

#include <glog/logging.h>

#include "cases.h"
#include "samara/base/errors.h"

int main(int argc, char** argv) {
  using namespace samara::benchmarks;
  FLAGS_minloglevel = google::GLOG_FATAL;
  try {
    const Options chosen = options(argc, argv);
    identification::coin_cases(chosen);
    identification::plate_cases(chosen);
    identification::posterior_case(chosen);
    identification::design_case(chosen);
    identification::body_cases(chosen);
    identification::segment_map_case(chosen);
    identification::table_tennis_case(chosen);
    identification::blimp_case(chosen);
    identification::falling_paper_case(chosen);
    identification::settling_plates_case(chosen);
    identification::april_paper_case(chosen);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
