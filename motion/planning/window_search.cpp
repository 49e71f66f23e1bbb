#include "samara/motion/planning/window_search.h"

#include <algorithm>
#include <cmath>

#include "samara/motion/planning/windows.h"

namespace samara::motion {

namespace {

constexpr std::size_t kStride = 3;  ///< knots from window to window

/// Pieces longer than one and a half of the median one, in three.
std::vector<CourseKnot> with_thirds(const PlannedFall& fall, const std::vector<CourseKnot>& knots,
                                    double end) {
  std::vector<double> lengths;
  for (std::size_t k = 0; k < knots.size(); ++k)
    lengths.push_back((k + 1 < knots.size() ? knots[k + 1].t : end) - knots[k].t);
  std::vector<double> sorted = lengths;
  std::ranges::sort(sorted);
  const double h = fall.plan().search.step;
  std::vector<CourseKnot> all;
  for (std::size_t k = 0; k < knots.size(); ++k) {
    all.push_back(knots[k]);
    const double third = h * std::round(lengths[k] / (3.0 * h));
    if (lengths[k] < 1.5 * sorted[sorted.size() / 2] || third < knots[k].ramp) continue;
    for (const double part : {third, 2.0 * third}) {
      CourseKnot between = knots[k];
      between.t = knots[k].t + part;
      all.push_back(between);
    }
  }
  return all;
}

}  // namespace

RefiningState RefiningState::from(const PlannedFall& fall, const FallPoint& start, const FoundFall& found) {
  RefiningState state;
  state.best = found;
  state.best.cost = replay(fall, start, found.knots).cost;
  // What turbulence costs goes by pieces: they stay those of the search.
  state.knots = fall.turbulence_factor() > 0.0 ? found.knots : with_thirds(fall, found.knots, found.end.t);
  return state;
}

bool refine_in_windows(const PlannedFall& fall, const FallPoint& start, RefiningState& state,
                       const ProgressCallback& progress, const std::function<void()>& keep) {
  while (state.sweep < fall.plan().search.sweeps) {
    Windows windows(fall, state.knots);
    const BookUse before_it = state.use;
    ReplayedFall now = replay(fall, start, state.knots);
    while (std::isfinite(now.cost) && state.first < now.at_knots.size()) {
      if (progress &&
          !progress({"refining", static_cast<double>(state.first) / static_cast<double>(state.knots.size())}))
        return false;
      const std::vector<CourseKnot> before = state.knots;
      if (windows.improve(state.first, now)) {
        ReplayedFall moved = replay(fall, start, state.knots);
        if (moved.cost < now.cost) {
          state.best = {.knots = state.knots, .end = moved.end, .cost = moved.cost};
          state.has_improved = true;
          now = std::move(moved);
        } else {
          state.knots = before;
        }
      }
      state.use = before_it + windows.use();
      state.first += kStride;
      if (keep) keep();
    }
    state.history.push_back({.stage = "windows",
                             .cost = state.best.cost,
                             .depth = fall.release_height() - state.best.end.height});
    if (!state.has_improved) break;
    state.first = 0;
    state.has_improved = false;
    ++state.sweep;
  }
  // Knots after the end of the fall move nothing.
  std::erase_if(state.best.knots, [&](const CourseKnot& knot) { return knot.t >= state.best.end.t; });
  return true;
}

}  // namespace samara::motion
