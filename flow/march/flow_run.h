#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "samara/flow/march/field_average.h"
#include "samara/flow/march/flow_march.h"
#include "samara/flow/march/load_history.h"

namespace samara::flow {

/// What is averaged over whole periods.
struct FlowMean {
  FieldAverage fields;
  std::vector<PeriodMeans> periods;
};

/// All that changes while solve_flow() works.
struct FlowRun {
  FlowRun(FlowSetup setup, std::string case_text)
      : march(std::move(setup)), mean(empty_mean()), text(std::move(case_text)) {}

  FlowMean empty_mean() const { return {FieldAverage(march.grid(), march.turbulence() != nullptr), {}}; }
  /// Of periods that have ended: what is averaged, or looked at until the drag has settled. Where the mean holds the
  /// end of a transient, it begins anew, and is kept until the new one has five periods.
  /// @param share to which the mean drag is to be known
  void add_period(const PeriodMeans& period, double share);
  /// The mean to give, if nothing follows.
  FlowMean& last_mean() { return older ? *older : mean; }

  FlowMarch march;
  FlowMean mean;
  std::optional<FlowMean> older;  ///< of which a transient was found, while the new one is short
  std::string text;               ///< of the case: a checkpoint of another one is refused
  PeriodCounter counter;
  std::vector<PeriodMeans> discarded;
  std::vector<LoadRecord> history;
  bool averaging = false, finite = true;
  double change = 0.0;  ///< per time, when it was looked at last
  double worst_disagreement = 0.0;
  double largest_force = 0.0;
  long unconverged = 0;   ///< steps whose pressure was not found to the tolerance
  long not_positive = 0;  ///< cells of all steps where k or eps was carried to 0 or below
};

}  // namespace samara::flow
