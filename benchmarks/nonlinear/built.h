#pragma once

#include <string>

#include "samara/codebooks/build/build.h"
#include "samara/codebooks/plan/plan.h"

namespace samara::benchmarks {

/// What a build of a plan came to.
struct Built {
  double certificate_max = 0.0;         ///< NaN where the certificate has no points
  double reached = 0.0;                 ///< end of the codebook's time over that of the plan
  double time = 0.0;                    ///< s, without the certificate
  double evaluation_fraction = 0.0;     ///< of what the same iterations on the builder's own grids would take
  double evaluation_fraction_14 = 0.0;  ///< the same with 14 nodes for every coordinate
  int rank = 0;                         ///< largest of a train
  int cells = 1;                        ///< boxes of parameters
  bool met = false;
  std::string status;
  std::string message;
};

Built build_and_measure(const codebooks::Plan& plan, int certificate_points = 2000);

}  // namespace samara::benchmarks
