#include "samara/motion/sweeps/refining.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/motion/sweeps/pattern_map.h"

namespace samara::motion {

namespace {

/// The points of the plan among those of the sweep, increasing: of a grid every so many along each axis, of drawn ones
/// the first.
std::vector<Eigen::Index> first_points(const SweepPlan& plan, const Sweep& sweep) {
  std::vector<Eigen::Index> points = {0};
  if (!plan.is_grid()) {
    points.resize(static_cast<std::size_t>(plan.sample));
    std::iota(points.begin(), points.end(), 0);
    return points;
  }
  for (std::size_t k = 0; k < plan.axes.size(); ++k) {
    const std::size_t old = plan.axes[k].values.size(), all = sweep.axes[k].size();
    const std::size_t step = old > 1 ? (all - 1) / (old - 1) : 1;
    std::vector<Eigen::Index> longer;
    for (const Eigen::Index point : points) {
      for (std::size_t n = 0; n < all; n += step)
        longer.push_back(point * static_cast<Eigen::Index>(all) + static_cast<Eigen::Index>(n));
    }
    points = std::move(longer);
  }
  return points;
}

RefiningRound held_out(const SweepPlan& plan, const Sweep& sweep) {
  RefiningRound round = {sweep.points.rows(), 0, 1.0};
  const std::vector<Eigen::Index> first = first_points(plan, sweep);
  for (Eigen::Index r = 0; r < sweep.release_count(); ++r) {
    const PatternMap map(sweep, r);
    round.run = map.run_count();
    round.agreement = std::min(round.agreement, map.left_one_out(first));
  }
  return round;
}

RefiningResult rounds_of(const SweepPlan& plan, const SweepOptions& options, Sweep& sweep) {
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

}  // namespace

RefiningResult refine_by_plan(const SweepPlan& plan, const SweepOptions& options, Sweep& sweep) {
  const auto begin = std::chrono::steady_clock::now();
  RefiningResult result = rounds_of(plan, options, sweep);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace samara::motion
