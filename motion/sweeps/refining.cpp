#include "samara/motion/sweeps/refining.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <numeric>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "samara/codebooks/book/sobol_points.h"
#include "samara/motion/sweeps/pattern_map.h"
#include "samara/motion/sweeps/sweep_checkpoint.h"
#include "samara/motion/sweeps/sweep_file.h"

namespace samara::motion {

namespace {

/// Points between old grid points: those that inherit, and those that are run.
struct NewPoints {
  Eigen::MatrixXd all;             ///< of the whole new grid
  std::vector<Eigen::Index> from;  ///< per new point the old one that it is or inherits from; -1: is run
};

std::vector<double> halved(const std::vector<double>& values) {
  std::vector<double> all;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (k > 0) all.push_back(0.5 * (values[k - 1] + values[k]));
    all.push_back(values[k]);
  }
  return all;
}

bool same_labels(const Sweep& sweep, Eigen::Index first, Eigen::Index second) {
  const Eigen::Index releases = sweep.release_count();
  for (Eigen::Index r = 0; r < releases; ++r) {
    if (sweep.labels[static_cast<std::size_t>(first * releases + r)].pattern !=
        sweep.labels[static_cast<std::size_t>(second * releases + r)].pattern)
      return false;
  }
  return true;
}

NewPoints new_points(const Sweep& sweep, const std::vector<std::vector<double>>& axes) {
  const std::size_t d = axes.size();
  Eigen::Index total = 1;
  for (const auto& axis : axes) total *= static_cast<Eigen::Index>(axis.size());
  NewPoints points;
  points.all.resize(total, static_cast<Eigen::Index>(d));
  points.from.assign(static_cast<std::size_t>(total), -1);
  std::vector<std::size_t> place(d, 0);
  for (Eigen::Index n = 0; n < total; ++n) {
    // Old points around it: both neighbours along axes where it lies between two.
    std::vector<Eigen::Index> corners = {0};
    for (std::size_t k = 0; k < d; ++k) {
      points.all(n, static_cast<Eigen::Index>(k)) = axes[k][place[k]];
      const auto size = static_cast<Eigen::Index>(sweep.axes[k].size());
      const auto below = static_cast<Eigen::Index>(place[k] / 2);
      const std::size_t before = corners.size();
      for (Eigen::Index& corner : corners) corner = corner * size + below;
      if (place[k] % 2 == 1) {
        for (std::size_t c = 0; c < before; ++c) corners.push_back(corners[c] + 1);
      }
    }
    const bool agree = std::ranges::all_of(
        corners, [&](Eigen::Index corner) { return same_labels(sweep, corner, corners.front()); });
    if (agree) points.from[static_cast<std::size_t>(n)] = corners.front();
    for (std::size_t k = d; k-- > 0;) {
      if (++place[k] < axes[k].size()) break;
      place[k] = 0;
    }
  }
  return points;
}

/// @param old whether the point is an old one, else what it has is inherited
void append_fall(const Sweep& source, std::size_t fall, bool old, Sweep& sweep) {
  const auto n = static_cast<Eigen::Index>(fall);
  sweep.labels.push_back(source.labels[fall]);
  sweep.features.push_back(old ? source.features[fall] : Features());
  sweep.features.back().seen = source.features[fall].seen;
  sweep.status.push_back(old ? source.status[fall] : FallStatus::inherited);
  if (!old) sweep.labels.back().why = "as all old points around it";
  const Eigen::Index at = sweep.fall_count() - 1;
  if (!source.trajectories.empty()) {
    const Eigen::MatrixXd& kept = source.trajectories[fall];
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    sweep.trajectories.push_back(old ? kept : Eigen::MatrixXd::Constant(kept.rows(), kept.cols(), unknown));
  }
  sweep.reached[at] = old ? source.reached[n] : 0.0;
  if (old) sweep.landing.row(at) = source.landing.row(n);
}

bool refine_grid(const SweepPlan& plan, const SweepOptions& options, int round, Sweep& sweep) {
  std::vector<std::vector<double>> axes;
  for (const auto& axis : sweep.axes) axes.push_back(halved(axis));
  const NewPoints points = new_points(sweep, axes);
  std::vector<Eigen::Index> run;
  for (Eigen::Index n = 0; n < points.all.rows(); ++n) {
    if (points.from[static_cast<std::size_t>(n)] < 0) run.push_back(n);
  }
  Sweep fresh = empty_sweep(plan);
  if (!append_falls(plan, points.all(run, Eigen::all), options, fresh)) return false;
  Sweep finer = empty_sweep(plan);
  finer.axes = axes;
  finer.points = points.all;
  finer.rounds = sweep.rounds;
  const Eigen::Index releases = sweep.release_count();
  finer.reached.resize(points.all.rows() * releases);
  finer.landing.setConstant(points.all.rows() * releases, 3, std::numeric_limits<double>::quiet_NaN());
  Eigen::Index next = 0;
  for (Eigen::Index n = 0; n < points.all.rows(); ++n) {
    const Eigen::Index from = points.from[static_cast<std::size_t>(n)];
    const bool old = from >= 0 && sweep.points.row(from) == points.all.row(n);
    for (Eigen::Index r = 0; r < releases; ++r) {
      if (from < 0) {
        append_fall(fresh, static_cast<std::size_t>(next * releases + r), true, finer);
      } else {
        append_fall(sweep, static_cast<std::size_t>(from * releases + r), old, finer);
      }
    }
    next += from < 0;
    const bool is_known = old && !sweep.round_of_point.empty();
    finer.round_of_point.push_back(is_known ? sweep.round_of_point[static_cast<std::size_t>(from)]
                                   : old    ? 0
                                            : round);
  }
  sweep = std::move(finer);
  return true;
}

bool refine_sample(const SweepPlan& plan, const SweepOptions& options, int round, Sweep& sweep) {
  const Eigen::Index wanted = std::max<Eigen::Index>(1, sweep.points.rows() / 5);
  // Candidates that no round had before: another scrambling for each size.
  Eigen::MatrixXd candidates =
      codebooks::sobol_points(static_cast<int>(sweep.lower.size()), static_cast<int>(4 * wanted),
                              plan.seed + 1 + static_cast<std::uint64_t>(sweep.points.rows()))
          .transpose();
  for (Eigen::Index k = 0; k < candidates.cols(); ++k)
    candidates.col(k) = sweep.lower[k] + (sweep.upper[k] - sweep.lower[k]) * candidates.col(k).array();
  Eigen::VectorXd agreement = Eigen::VectorXd::Ones(candidates.rows());
  for (Eigen::Index r = 0; r < sweep.release_count(); ++r) {
    const PatternMap map(sweep, r);
    for (Eigen::Index n = 0; n < candidates.rows(); ++n)
      agreement[n] = std::min(agreement[n], map.at(candidates.row(n)).probability);
  }
  std::vector<Eigen::Index> order(static_cast<std::size_t>(candidates.rows()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](Eigen::Index n) { return agreement[n]; });
  order.resize(static_cast<std::size_t>(wanted));
  const auto before = static_cast<std::size_t>(sweep.points.rows());
  if (!append_falls(plan, candidates(order, Eigen::all), options, sweep)) return false;
  std::fill(sweep.round_of_point.begin() + static_cast<std::ptrdiff_t>(before), sweep.round_of_point.end(),
            round);
  return true;
}

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

/// Why refining ends after these rounds; empty: it goes on.
std::string end_of_rounds(const SweepPlan& plan, const std::vector<RefiningRound>& rounds) {
  const int done = static_cast<int>(rounds.size()) - 1;
  if (done > 0 && plan.refine_gain) {
    const double gain = rounds.back().agreement - rounds[rounds.size() - 2].agreement;
    if (gain < *plan.refine_gain) {
      return fmt::format("round {} adds {:.2g} % to the agreement, less than {:.2g} %", done, 100.0 * gain,
                         100.0 * *plan.refine_gain);
    }
  }
  return done >= plan.refine ? fmt::format("all {} rounds", plan.refine) : "";
}

RefiningResult rounds_of(const SweepPlan& plan, const SweepOptions& options, Sweep& sweep) {
  const auto save =
      codebooks::told_once<>([&] { save_checkpoint(sweep, options.checkpoint); }, options.warning);
  const auto keep = [&] {
    if (!options.checkpoint.empty()) save();
  };
  if (sweep.rounds.empty()) {
    sweep.rounds.push_back(held_out(plan, sweep));
    keep();
  }
  RefiningResult result;
  for (;;) {
    result.rounds = sweep.rounds;
    result.message = end_of_rounds(plan, sweep.rounds);
    result.complete = !result.message.empty();
    if (result.complete) return result;
    if (!refine(plan, options, sweep)) {
      result.message = fmt::format("cancelled in round {}", sweep.rounds.size());
      return result;
    }
    sweep.rounds.push_back(held_out(plan, sweep));
    keep();
  }
}

}  // namespace

bool refine(const SweepPlan& plan, const SweepOptions& options, Sweep& sweep) {
  const auto& rounds = sweep.round_of_point;
  const int round = 1 + (rounds.empty() ? 0 : *std::ranges::max_element(rounds));
  return plan.is_grid() ? refine_grid(plan, options, round, sweep)
                        : refine_sample(plan, options, round, sweep);
}

RefiningResult refine_by_plan(const SweepPlan& plan, const SweepOptions& options, Sweep& sweep) {
  const auto begin = std::chrono::steady_clock::now();
  codebooks::check_checkpoint_path(options.checkpoint, kSweepCheckpoint);
  RefiningResult result = rounds_of(plan, options, sweep);
  if (result.complete && !options.checkpoint.empty() && !options.keep_checkpoint) {
    std::error_code ignored;
    std::filesystem::remove(options.checkpoint, ignored);
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace samara::motion
