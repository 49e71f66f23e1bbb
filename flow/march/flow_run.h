#pragma once

#include <string>
#include <utility>
#include <vector>

#include "samara/flow/march/field_average.h"
#include "samara/flow/march/flow_march.h"
#include "samara/flow/march/load_history.h"

namespace samara::flow {

/// All that changes while solve_flow() works.
struct FlowRun {
  FlowRun(FlowSetup setup, std::string case_text)
      : march(std::move(setup)),
        average(march.grid(), march.turbulence() != nullptr),
        text(std::move(case_text)) {}

  FlowMarch march;
  FieldAverage average;
  std::string text;  ///< of the case: a checkpoint of another one is refused
  PeriodCounter counter;
  std::vector<PeriodMeans> discarded, averaged;
  std::vector<LoadRecord> history;
  bool averaging = false, finite = true;
  double change = 0.0;  ///< per time, when it was looked at last
  double worst_disagreement = 0.0;
  double largest_force = 0.0;
  long unconverged = 0;   ///< steps whose pressure was not found to the tolerance
  long not_positive = 0;  ///< cells of all steps where k or eps was carried to 0 or below
};

}  // namespace samara::flow
