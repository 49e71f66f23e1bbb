#include "samara/motion/sweeps/refining.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/motion/sweeps/pattern_map.h"

namespace samara::motion {

namespace {

RefiningRound held_out(const SweepPlan& plan, const Sweep& sweep) {
  RefiningRound round = {sweep.points.rows(), 1.0};
  for (Eigen::Index r = 0; r < sweep.release_count(); ++r) {
    const PatternMap map(sweep, r);
    round.agreement = std::min(round.agreement, map.left_one_out(plan.is_grid() ? map.size() : plan.sample));
  }
  return round;
}

}  // namespace

RefiningResult refine_by_plan(const SweepPlan& plan, const SweepOptions& options, Sweep& sweep) {
  RefiningResult result;
  result.rounds.push_back(held_out(plan, sweep));
  for (int round = 0; round < plan.refine; ++round) {
    if (!refine(plan, options, sweep)) {
      result.message = fmt::format("cancelled in round {}", round + 1);
      return result;
    }
    const double before = result.rounds.back().agreement;
    result.rounds.push_back(held_out(plan, sweep));
    const double gain = result.rounds.back().agreement - before;
    if (plan.refine_gain && gain < *plan.refine_gain) {
      result.complete = true;
      result.message = fmt::format("round {} adds {:.2g} % to the agreement, less than {:.2g} %", round + 1,
                                   100.0 * gain, 100.0 * *plan.refine_gain);
      return result;
    }
  }
  result.complete = true;
  result.message = fmt::format("all {} rounds", plan.refine);
  return result;
}

}  // namespace samara::motion
