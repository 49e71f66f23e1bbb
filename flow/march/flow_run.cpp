#include "samara/flow/march/flow_run.h"

namespace samara::flow {

void FlowRun::add_period(const PeriodMeans& period, double share) {
  constexpr std::size_t kLeastPeriods = 5;
  if (!averaging) {
    discarded.push_back(period);
    averaging = is_settled(discarded);
    return;
  }
  mean.periods.push_back(period);
  if (mean.periods.size() >= kLeastPeriods) older.reset();
  if (!holds_transient(mean.periods, share)) return;
  discarded.insert(discarded.end(), mean.periods.begin(), mean.periods.end());
  older = std::exchange(mean, empty_mean());
}

}  // namespace samara::flow
