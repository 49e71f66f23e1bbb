#include "samara/identification/fit/fit.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include <fmt/format.h>

#include "samara/base/parallel.h"
#include "samara/identification/fit/bootstrap.h"
#include "samara/identification/fit/delay_check.h"
#include "samara/identification/fit/fill_result.h"
#include "samara/identification/fit/fit_diagnostics.h"
#include "samara/identification/fit/fit_warnings.h"
#include "samara/identification/fit/integration_check.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/measurement.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/join_weights.h"
#include "samara/identification/solve/minimize.h"
#include "samara/identification/solve/motion_terms.h"
#include "samara/identification/solve/noise_levels.h"
#include "samara/identification/solve/other_optima.h"
#include "samara/identification/solve/starts/choose_start_states.h"
#include "samara/identification/solve/starts/global_search.h"
#include "samara/identification/solve/starts/start_point.h"
#include "samara/identification/solve/uncertainty.h"

namespace samara::identification {

namespace {

/// Costs that differ by less are equal: a millionth, and what rounding leaves of an exact fit.
double cost_margin(const FitProblem& problem, double best) {
  return 1e-6 * best + 1e-9 * problem.observation_count();
}

/// Whether the start is to be made.
bool goes_on(const FitOptions& options, int start) {
  if (!options.progress) return true;
  const bool wanted =
      options.progress({.stage = fmt::format("start {} of {}", start + 1, options.starts.count),
                        .fraction = static_cast<double>(start) / options.starts.count});
  return wanted || start == 0;
}

/// The descents of a fit, one per start: side by side, each but the first with residuals of its own, so that none
/// depends on when the others end.
class Descents {
 public:
  /// @param residuals of the whole fit: those of the first start
  Descents(const models::TrajectoryFamily& family, const FitProblem& problem,
           std::vector<SegmentResidual>& residuals, const FitOptions& options)
      : family_(family), problem_(problem), residuals_(residuals), options_(options) {}

  /// From starts, all or until the callback asks for an end, to minima.
  std::vector<MinimizeResult> run() {
    weigh_for_all();
    // Whoever watches is told of starts before they begin, as many at a time as there are threads.
    const int wave = options_.progress ? std::max(1, static_cast<int>(std::thread::hardware_concurrency()))
                                       : options_.starts.count;
    std::vector<MinimizeResult> runs;
    for (bool wanted = true; wanted && std::ssize(runs) < options_.starts.count;) {
      const int first = static_cast<int>(runs.size());
      int last = first;
      while (wanted && last < std::min(first + wave, options_.starts.count)) {
        wanted = goes_on(options_, last);
        if (wanted) ++last;
      }
      runs.resize(static_cast<std::size_t>(last));
      const auto all = [](int) { return true; };
      with_residuals(first, last, all, [&](int k, std::vector<SegmentResidual>& residuals) {
        runs[static_cast<std::size_t>(k)] = descend(k, residuals);
      });
    }
    finish_joins(residuals_);
    return runs;
  }

  /// After the scales of residuals have changed: weighs joins anew, at the best of the minima, and goes from the minima
  /// to those beside them.
  void again(std::size_t best, std::vector<MinimizeResult>& runs) {
    if (problem_.is_joined()) {
      if (const auto deviations = start_deviations(problem_, residuals_, runs[best].point))
        deviations_ = deviations;
      finish_joins(residuals_);  // which others read, also where the first start has failed
    }
    const auto wanted = [&](int k) {
      return runs[static_cast<std::size_t>(k)].status != Termination::failed;
    };
    with_residuals(
        0, static_cast<int>(runs.size()), wanted, [&](int k, std::vector<SegmentResidual>& residuals) {
          MinimizeResult& run = runs[static_cast<std::size_t>(k)];
          finish_joins(residuals);
          const int before = run.iterations;
          run = minimize(problem_, residuals, std::move(run.point), options_.solver.max_iterations);
          run.iterations += before;
        });
  }

  /// The first start, from a search of the box.
  std::optional<GlobalSearch> search() {
    if (options_.starts.global.method == GlobalMethod::none || problem_.shared_count() == 0) return {};
    searched_.emplace(first_point(0, residuals_));
    return search_box(problem_, residuals_, options_.starts.global, FitPoint(*searched_), *searched_);
  }

  /// The largest difference between a segment's end and the next start, at the residuals' last point, over
  /// the deviations of starts.
  double join_defect() const {
    double largest = 0.0;
    for (const SegmentResidual& residual : residuals_) {
      if (!residual.segment().joined) continue;
      const auto joins = residual.residual().tail(residual.join_size());
      largest = std::max(largest, joins.cwiseAbs().maxCoeff());
    }
    return largest / options_.segments.stages.back();
  }

  /// Trajectories of all starts but the first, whose residuals count their own.
  long evaluations() const { return evaluations_; }

 private:
  /// Calls action(start, its residuals) for first <= start < last, if wanted(start), in any order.
  template <class Wanted, class Action>
  void with_residuals(int first, int last, const Wanted& wanted, const Action& action) {
    parallel_for(std::max(0, last - first), [&](int k) {
      if (!wanted(first + k)) return;
      if (first + k == 0) return action(0, residuals_);
      std::vector<SegmentResidual> own = make_residuals(family_, problem_);
      action(first + k, own);
      evaluations_ += evaluations_of(own);
    });
  }

  /// How joins are weighed is the same for all starts, or their costs could not be compared: as at the first that has
  /// trajectories.
  void weigh_for_all() {
    for (int k = 0; problem_.is_joined() && !deviations_ && k < options_.starts.count; ++k) {
      FitPoint point = first_point(k, residuals_);
      deviations_ = start_deviations(problem_, residuals_, point);
      if (k == 0) first_ = std::move(point);
    }
  }

  /// From a start to a minimum; where there are joins, stage by stage until they hold.
  MinimizeResult descend(int start, std::vector<SegmentResidual>& residuals) const {
    FitPoint point = start == 0 && first_ ? *first_ : first_point(start, residuals);
    if (!problem_.is_joined()) return in_rounds(std::move(point), residuals);
    if (!deviations_) {
      evaluate_all(residuals, point);
      return {.point = std::move(point), .message = failure_of(residuals)};
    }
    MinimizeResult result;
    int iterations = 0;
    for (const double stage : options_.segments.stages) {
      weigh_joins(stage, residuals);
      result = minimize(problem_, residuals, std::move(point), options_.solver.max_iterations);
      iterations += result.iterations;
      point = result.point;
      if (result.status == Termination::failed) break;
    }
    result.iterations = iterations;
    return result;
  }

  /// Joins as the last stage has them, whatever the first start made of them: for all that is asked of a
  /// minimum.
  void finish_joins(std::vector<SegmentResidual>& residuals) const {
    if (deviations_) weigh_joins(options_.segments.stages.back(), residuals);
  }

  /// Segments of a capture have one camera and one clock from the first stage on, since alone they hardly
  /// determine them.
  void weigh_joins(double stage, std::vector<SegmentResidual>& residuals) const {
    Eigen::VectorXd weights = stage * deviations_->cwiseInverse();
    Eigen::Index row = 0;
    for (const JoinRule& rule : problem_.joins) {
      if (is_of_measurement(problem_, rule.own)) weights[row] *= options_.segments.stages.back() / stage;
      row += rule.rows();
    }
    for (SegmentResidual& residual : residuals) {
      if (residual.segment().joined) residual.set_join_weights(weights);
    }
  }

  /// To a minimum, with start states found anew in each round; the best round.
  MinimizeResult in_rounds(FitPoint point, std::vector<SegmentResidual>& residuals) const {
    MinimizeResult best = minimize(problem_, residuals, std::move(point), options_.solver.max_iterations);
    const models::ParametricModel* equations = family_.equations();
    if (equations == nullptr || !options_.segments.length) return best;
    for (int round = 1; round < options_.starts.rounds && best.status != Termination::failed; ++round) {
      FitPoint again = best.point;
      choose_start_states(*equations, problem_, residuals, again, true);
      MinimizeResult next = minimize(problem_, residuals, std::move(again), options_.solver.max_iterations);
      const int spent = best.iterations + next.iterations;
      const bool is_better =
          next.status != Termination::failed && next.cost < best.cost - cost_margin(problem_, best.cost);
      if (is_better) best = std::move(next);
      best.iterations = spent;
      if (!is_better) break;
    }
    return best;
  }

  /// Segments begin where the capture shows them.
  FitPoint first_point(int start, std::vector<SegmentResidual>& residuals) const {
    FitPoint point = start_point(problem_, residuals, start);
    if (start == 0 && searched_) point.shared = searched_->shared;
    const models::ParametricModel* equations = family_.equations();
    if (equations != nullptr && options_.segments.length) {
      choose_start_states(*equations, problem_, residuals, point);
    }
    return point;
  }

  const models::TrajectoryFamily& family_;
  const FitProblem& problem_;
  std::vector<SegmentResidual>& residuals_;
  const FitOptions& options_;
  std::optional<Eigen::VectorXd> deviations_;
  std::optional<FitPoint> searched_;
  std::optional<FitPoint> first_;  ///< of the first start, once it is known
  std::atomic<long> evaluations_ = 0;
};

/// Index of the lowest cost among the starts that did not fail.
std::optional<std::size_t> best_of(const std::vector<MinimizeResult>& runs) {
  std::optional<std::size_t> best;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    if (runs[k].status == Termination::failed) continue;
    if (!best || runs[k].cost < runs[*best].cost) best = k;
  }
  return best;
}

void record_starts(const FitProblem& problem, const std::vector<MinimizeResult>& runs,
                   std::optional<std::size_t> best, FitResult& result) {
  for (const MinimizeResult& run : runs) {
    StartRecord record{.status = run.status,
                       .message = run.message,
                       .coefficients = {run.point.shared.begin(), run.point.shared.end()},
                       .cost = run.cost,
                       .iterations = run.iterations};
    if (best && run.status != Termination::failed) {
      const double lowest = runs[*best].cost;
      record.reached_best = run.cost <= lowest + cost_margin(problem, lowest);
    }
    result.starts_at_best += record.reached_best ? 1 : 0;
    result.iterations += run.iterations;
    result.starts.push_back(std::move(record));
  }
}

/// Noise levels and fit in turn, until the levels stand still.
void estimate_noise(NoiseLevels& levels, int rounds, FitProblem& problem,
                    std::vector<SegmentResidual>& residuals, Descents& descend,
                    std::vector<MinimizeResult>& runs, FitResult& result) {
  constexpr double kStill = 0.01;
  double change = 1.0;
  for (; result.noise_rounds < rounds && change > kStill; ++result.noise_rounds) {
    const std::optional<std::size_t> best = best_of(runs);
    if (levels.empty() || !best) return;
    change = levels.update(problem, residuals, runs[*best].point);
    descend.again(*best, runs);
  }
  if (change > kStill) {
    result.warnings.add(WarningKind::noise,
                        fmt::format("the noise levels still moved by {:.2g} % in the last of {} rounds",
                                    100.0 * change, rounds));
  }
}

void conclude(const MinimizeResult& best, const Uncertainty& uncertainty, int max_iterations,
              FitResult& result) {
  result.status = best.status;
  const std::string reached = fmt::format("{} of {} starts reached the best cost, {:.6g}",
                                          result.starts_at_best, result.starts.size(), result.cost);
  if (best.status == Termination::max_iterations) {
    result.message = fmt::format("did not converge within {} iterations{}; {}", max_iterations,
                                 best.iterations > max_iterations ? " of a stage" : "", reached);
  } else if (!uncertainty.undetermined_sets.empty()) {
    result.status = Termination::not_determined;
    result.message =
        fmt::format("converged, but the captures do not determine all coefficients; {}", reached);
  } else {
    result.message = fmt::format("converged; {}", reached);
  }
}

/// @param objective null if it is not wanted
FitResult fitted(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                 const FitOptions& options, std::shared_ptr<const FitObjective>* objective) {
  const auto begin = std::chrono::steady_clock::now();
  FitProblem problem = make_problem(family.info(), captures, options);
  NoiseLevels levels(options.noise, problem);
  std::vector<SegmentResidual> residuals = make_residuals(family, problem);

  Descents descend(family, problem, residuals, options);
  const std::optional<GlobalSearch> search = descend.search();
  std::vector<MinimizeResult> runs = descend.run();

  FitResult result{.model = family.info().model,
                   .source = family.info().source,
                   .loss = to_string(problem.loss),
                   .fixed = problem.fixed};
  add_setup(family.info(), problem, options, result);
  add_capture_warnings(family, captures, options, result);
  result.global_search = search;
  estimate_noise(levels, options.noise.rounds, problem, residuals, descend, runs, result);
  const std::optional<std::size_t> best = best_of(runs);
  record_starts(problem, runs, best, result);
  if (best) {
    const FitPoint& point = runs[*best].point;
    result.cost = runs[*best].cost;
    const Uncertainty uncertainty =
        estimate_uncertainty(problem, residuals, point, options.uncertainty.profiles);
    result.information = uncertainty.information;
    if (problem.is_joined()) result.join_defect = descend.join_defect();
    add_coefficients(problem, point, uncertainty, result);
    add_captures(problem, residuals, point, uncertainty, result);
    conclude(runs[*best], uncertainty, options.solver.max_iterations, result);
    add_misfit_warnings(problem, result);
    add_start_warning(family, options, result);
    add_warnings(problem, point, uncertainty, result);
    levels.report(problem, result);
    add_delay_warning(family, problem, residuals, point, result);
    add_integration_shift(family, problem, residuals, point, uncertainty, result);
    add_whiteness(result);
    add_identifiability(problem, uncertainty, result);
    if (options.uncertainty.profiles) {
      add_profiles(family, problem, residuals, point, uncertainty, options.solver.max_iterations, result);
      add_profile_warnings(result);
    }
    add_bootstrap(family, problem, residuals, point, options, result);
    add_posterior(family, problem, residuals, point, uncertainty, options, result);
    add_other_optima(problem, residuals, runs, *best, result);
    if (objective)
      *objective = std::make_shared<FitObjective>(family, problem, residuals, point, uncertainty.dispersion);
  } else {
    result.message =
        fmt::format("none of {} starts succeeded; the first: {}", runs.size(), runs.front().message);
    add_speed_warnings(family, captures, result);
  }
  result.evaluations += evaluations_of(residuals) + descend.evaluations();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace

FitResult fit(const models::TrajectoryFamily& family, std::span<const Capture> captures,
              const FitOptions& options) {
  return fitted(family, captures, options, nullptr);
}

FitResult fit(const models::TrajectoryFamily& family, std::span<const Capture> captures,
              const FitOptions& options, std::shared_ptr<const FitObjective>& objective) {
  objective.reset();
  return fitted(family, captures, options, &objective);
}

}  // namespace samara::identification
