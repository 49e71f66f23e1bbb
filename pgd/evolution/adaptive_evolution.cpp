#include "samara/pgd/evolution/adaptive_evolution.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/fields/resolution.h"

namespace samara::pgd {

namespace {

constexpr double kShare = 0.3;  ///< of the tolerance, for each kind of error
constexpr int kSamples = 400;
/// Of the residual that a field carried over to finer axes has: what one Newton step reaches.
constexpr double kForcedReduction = 0.1;
constexpr double kRounding = 1e-14;  ///< residual that no step can reduce

/// A system that may be evaluated a number of times only. Beyond it every value is NaN, at which the solver
/// ends with the field it has.
class LimitedSystem : public EvolutionSystem {
 public:
  /// @param most evaluations of f and J together; 0: no limit
  LimitedSystem(const EvolutionSystem& system, long most) : system_(system), most_(most) {}

  int state_count() const override { return system_.state_count(); }
  void rhs(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
           Eigen::MatrixXd& f) const override {
    if (take(t.size(), rhs_used_)) return system_.rhs(t, x, q, f);
    f.setConstant(state_count(), t.size(), kNan);
  }
  void jacobian(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                Eigen::MatrixXd& jacobian) const override {
    if (take(t.size(), jacobian_used_)) return system_.jacobian(t, x, q, jacobian);
    jacobian.setConstant(Eigen::Index{state_count()} * state_count(), t.size(), kNan);
  }

  bool exhausted() const { return exhausted_; }
  long rhs_used() const { return rhs_used_; }
  long jacobian_used() const { return jacobian_used_; }

 private:
  static constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

  bool take(long count, std::atomic<long>& used) const {
    if (exhausted_) return false;
    if (most_ > 0 && rhs_used_ + jacobian_used_ + count > most_) {
      exhausted_ = true;
      return false;
    }
    used += count;
    return true;
  }

  const EvolutionSystem& system_;
  const long most_;
  mutable std::atomic<long> rhs_used_ = 0;
  mutable std::atomic<long> jacobian_used_ = 0;
  mutable std::atomic<bool> exhausted_ = false;
};

class AdaptiveSolver {
 public:
  AdaptiveSolver(const AdaptiveProblem& problem, const AdaptiveOptions& options, SolverState start)
      : problem_(problem), options_(options), state_(std::move(start)) {
    if (state_.round > 0) return;
    state_.time_elements = options.first_time_elements;
    for (const AdaptiveAxis& axis : problem.parameters)
      state_.nodes.push_back(axis.nodes.value_or(options.first_nodes));
    state_.scales = problem.scales;
    state_.coarseness = 1.0;
  }

  AdaptiveResult run() {
    while (true) {
      const double tolerance = round_tolerance();
      EvolutionResult evolution = solve_with_a_step(tolerance);
      advance(evolution);
      const std::vector<AxisResolution> resolution = measure();
      const AxisResolution* const coarsest = refine(resolution);
      const bool final_tolerance = tolerance <= final_round_tolerance();
      AdaptiveResult result{std::move(evolution), AdaptiveStatus::not_resolved, {}, resolution, state_};
      if (finished(result, coarsest, final_tolerance)) return result;
      if (options_.checkpoint) options_.checkpoint(state_);
    }
  }

 private:
  double final_round_tolerance() const { return kShare * options_.tolerance / options_.peak_factor; }

  /// A tenth of what the axes of the last round left unresolved.
  double round_tolerance() const {
    return std::max(final_round_tolerance(), 0.1 * std::min(state_.coarseness, 0.1));
  }

  /// On finer axes than those of the field so far, a field that is only carried over says nothing: its
  /// highest coefficients are zero. Where its residual is below the tolerance already, it is made to take a
  /// Newton step.
  EvolutionResult solve_with_a_step(double tolerance) {
    EvolutionResult carried = solve(tolerance);
    if (carried.status != Termination::converged || carried.history.size() > 1 || !refined(carried.field) ||
        carried.residual <= kRounding) {
      return carried;
    }
    evaluations_of_round_ = carried.rhs_evaluations + carried.jacobian_evaluations;
    EvolutionResult stepped = solve(kForcedReduction * carried.residual);
    evaluations_of_round_ = 0;
    stepped.rhs_evaluations += carried.rhs_evaluations;
    stepped.jacobian_evaluations += carried.jacobian_evaluations;
    if (stepped.status == Termination::converged || stepped.status == Termination::cancelled) return stepped;
    // Near rounding a step cannot do what was asked of it; it need not have done harm.
    const bool good_enough = stepped.residual <= tolerance && stepped.nonlinearity_error <= tolerance;
    EvolutionResult& kept = good_enough ? stepped : carried;
    kept.status = Termination::converged;
    kept.message = fmt::format("residual {:.3g} <= {:.3g} after {} iterations", kept.residual, tolerance,
                               kept.history.size());
    kept.rhs_evaluations = stepped.rhs_evaluations;
    kept.jacobian_evaluations = stepped.jacobian_evaluations;
    return std::move(kept);
  }

  /// Whether the field lies over other axes than that of the round before.
  bool refined(const SeparatedField& field) const {
    if (!state_.field) return false;
    const std::vector<Axis>& before = state_.field->axes();
    return !std::equal(before.begin(), before.end(), field.axes().begin(), field.axes().end(),
                       [](const Axis& a, const Axis& b) { return a.size() == b.size(); });
  }

  EvolutionResult solve(double tolerance) {
    const LimitedSystem limited(*problem_.system, evaluations_left());
    EvolutionProblem problem{
        options_.max_evaluations > 0 ? &limited : problem_.system,
        Axis::radau(problem_.time, 0.0, problem_.end, state_.time_elements, options_.time_points),
        {},
        problem_.states,
        state_.scales,
        problem_.initial};
    for (std::size_t k = 0; k < problem_.parameters.size(); ++k) {
      problem.parameters.push_back(make_axis(problem_.parameters[k], state_.nodes[k]));
    }
    EvolutionOptions evolution = options_.evolution;
    evolution.tolerance = tolerance;
    EvolutionResult result = solve_evolution(problem, evolution, state_.field ? &*state_.field : nullptr);
    if (!limited.exhausted()) return result;
    // The solver shortened its last step because of the NaN: a field of the round before is better. What was
    // asked for, but not evaluated, does not count.
    exhausted_budget_ = true;
    if (state_.field) result.field = *state_.field;
    result.rhs_evaluations = limited.rhs_used();
    result.jacobian_evaluations = limited.jacobian_used();
    return result;
  }

  /// 0: no limit
  long evaluations_left() const {
    if (options_.max_evaluations == 0) return 0;
    return std::max(1L, options_.max_evaluations - state_.rhs_evaluations - state_.jacobian_evaluations -
                            evaluations_of_round_);
  }

  void advance(const EvolutionResult& evolution) {
    ++state_.round;
    state_.field = evolution.field;
    state_.rhs_evaluations += evolution.rhs_evaluations;
    state_.jacobian_evaluations += evolution.jacobian_evaluations;
    state_.iterations += static_cast<int>(evolution.history.size()) - 1;
    const std::vector<double> ranges = sampled_ranges(*state_.field, kSamples, options_.evolution.seed);
    for (std::size_t s = 0; s < ranges.size(); ++s) {
      const double scale = std::max(ranges[s], problem_.scale_floors[s]);
      if (std::isfinite(scale) && scale > 0.0) state_.scales[s] = scale;
    }
  }

  std::vector<AxisResolution> measure() const {
    std::vector<AxisResolution> resolution;
    for (int k = 0; k < state_.field->axis_count(); ++k) {
      const Axis& axis = state_.field->axes()[static_cast<std::size_t>(k)];
      resolution.push_back(
          {axis.name(),
           highest_coefficients(*state_.field, k, state_.scales, kSamples, options_.evolution.seed),
           axis.size()});
    }
    return resolution;
  }

  /// More nodes where an axis does not resolve the field, as far as they are allowed.
  /// @returns the axis that resolves it worst of those (rather one that can have no more), null if all do
  const AxisResolution* refine(const std::vector<AxisResolution>& resolution) {
    const double share = kShare * options_.tolerance;
    const AxisResolution* worst = nullptr;
    exhausted_ = false;
    state_.coarseness = 0.0;
    const auto grow = [&](const AxisResolution& axis, int& size, int step, int most) {
      if (!(axis.coefficients > share)) return;
      state_.coarseness = std::max(state_.coarseness, axis.coefficients);
      const bool full = size >= most;
      const bool worse = worst == nullptr || axis.coefficients > worst->coefficients;
      if (full == exhausted_ ? worse : full) worst = &axis;
      exhausted_ = exhausted_ || full;
      if (!full) size = std::min(size + step, most);
    };
    grow(resolution[0], state_.time_elements, std::max(1, state_.time_elements / 2),
         options_.max_time_elements);
    for (std::size_t k = 0; k < state_.nodes.size(); ++k) {
      if (problem_.parameters[k].nodes) continue;
      grow(resolution[k + 1], state_.nodes[k], std::max(2, state_.nodes[k] / 2), options_.max_nodes);
    }
    return worst;
  }

  /// @param coarsest an axis that does not resolve the field, or null
  bool finished(AdaptiveResult& result, const AxisResolution* coarsest, bool final_tolerance) const {
    const auto end = [&](AdaptiveStatus status, std::string message) {
      result.status = status;
      result.message = std::move(message);
      return true;
    };
    const long evaluations = state_.rhs_evaluations + state_.jacobian_evaluations;
    if (exhausted_budget_) {
      return end(AdaptiveStatus::max_evaluations, fmt::format("{} evaluations used, no more than {} allowed",
                                                              evaluations, options_.max_evaluations));
    }
    if (result.evolution.status != Termination::converged) {
      return end(AdaptiveStatus::evolution_failed, result.evolution.message);
    }
    if (coarsest == nullptr && final_tolerance) {
      return end(AdaptiveStatus::converged,
                 fmt::format("{} rounds of refinement; {}", state_.round, result.evolution.message));
    }
    if (options_.max_evaluations > 0 && evaluations >= options_.max_evaluations) {
      return end(AdaptiveStatus::max_evaluations,
                 fmt::format("{} evaluations used, {} allowed", evaluations, options_.max_evaluations));
    }
    // Axes that resolve the field need one round more at most, for the final tolerance.
    if (coarsest == nullptr || !(exhausted_ || state_.round >= options_.max_rounds)) return false;
    return end(
        AdaptiveStatus::not_resolved,
        fmt::format("the axis {} does not resolve the solution: with {} nodes {:.3g} of its scale is "
                    "left, more than {:.3g}, and {}",
                    coarsest->axis, coarsest->nodes, coarsest->coefficients, kShare * options_.tolerance,
                    exhausted_ ? "no more are allowed"
                               : fmt::format("all {} rounds of refinement are used", state_.round)));
  }

  const AdaptiveProblem& problem_;
  const AdaptiveOptions& options_;
  SolverState state_;
  long evaluations_of_round_ = 0;  // by a solve of this round that is done
  bool exhausted_budget_ = false;
  bool exhausted_ = false;  // an axis that needs more nodes has as many as are allowed
};

}  // namespace

AdaptiveResult solve_adaptively(const AdaptiveProblem& problem, const AdaptiveOptions& options,
                                SolverState start) {
  if (!(options.tolerance > 0.0) || !(options.peak_factor >= 1.0) || options.time_points < 1 ||
      options.first_time_elements < 1 || options.first_nodes < 2 || options.max_rounds < 1) {
    throw ArgumentError(
        fmt::format("AdaptiveOptions: tolerance {}, peak_factor {}, time_points {}, first_time_elements {}, "
                    "first_nodes {}, max_rounds {}; expected a positive tolerance, a factor of at least 1, "
                    "positive numbers and at least 2 nodes",
                    options.tolerance, options.peak_factor, options.time_points, options.first_time_elements,
                    options.first_nodes, options.max_rounds));
  }
  check_problem(problem);
  return AdaptiveSolver(problem, options, std::move(start)).run();
}

}  // namespace samara::pgd
