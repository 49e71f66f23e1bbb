#include "samara/pgd/adaptive_evolution.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/resolution.h"

namespace samara::pgd {

namespace {

constexpr double kShare = 0.3;  ///< of the tolerance, for each kind of error
constexpr int kSamples = 400;

Axis make_axis(const AdaptiveAxis& axis, int nodes) {
  switch (axis.basis) {
    case Basis::p1:
      return Axis::p1(axis.label, axis.lower, axis.upper, nodes);
    case Basis::p2:
      return Axis::p2(axis.label, axis.lower, axis.upper, nodes / 2);
    case Basis::legendre:
      return Axis::legendre(axis.label, axis.lower, axis.upper, nodes);
    case Basis::fourier:
      return Axis::fourier(axis.label, axis.lower, axis.upper, nodes / 2 * 2 + 1);
    default:
      return Axis::chebyshev(axis.label, axis.lower, axis.upper, nodes);
  }
}

void check_axis(const AdaptiveAxis& axis) {
  const bool elements = axis.basis == Basis::p1 || axis.basis == Basis::p2;
  const bool refined =
      axis.basis == Basis::chebyshev || axis.basis == Basis::legendre || axis.basis == Basis::fourier;
  if (refined || (elements && axis.nodes)) return;
  throw ArgumentError(
      fmt::format("axis \"{}\" is {}, expected chebyshev, legendre, fourier, or p1 or p2 with "
                  "a number of nodes",
                  axis.label.name, to_string(axis.basis)));
}

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
      EvolutionResult evolution = solve(tolerance);
      advance(evolution);
      const std::vector<AxisResolution> resolution = measure();
      const bool fine = refine(resolution);
      const bool final_tolerance = tolerance <= final_round_tolerance();
      AdaptiveResult result{std::move(evolution), AdaptiveStatus::not_resolved, {}, resolution, state_};
      if (finished(result, fine && final_tolerance)) return result;
      if (options_.checkpoint) options_.checkpoint(state_);
    }
  }

 private:
  double final_round_tolerance() const { return kShare * options_.tolerance / options_.peak_factor; }

  /// A tenth of what the axes of the last round left unresolved.
  double round_tolerance() const {
    return std::max(final_round_tolerance(), 0.1 * std::min(state_.coarseness, 0.1));
  }

  EvolutionResult solve(double tolerance) const {
    EvolutionProblem problem{
        problem_.system,
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
    return solve_evolution(problem, evolution, state_.field ? &*state_.field : nullptr);
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

  std::vector<AxisResolution> measure() {
    std::vector<AxisResolution> resolution;
    state_.coarseness = 0.0;
    for (int k = 0; k < state_.field->axis_count(); ++k) {
      const Axis& axis = state_.field->axes()[static_cast<std::size_t>(k)];
      resolution.push_back(
          {axis.name(),
           highest_coefficients(*state_.field, k, state_.scales, kSamples, options_.evolution.seed),
           axis.size()});
      state_.coarseness = std::max(state_.coarseness, resolution.back().coefficients);
    }
    return resolution;
  }

  /// More nodes where the axis does not resolve the field. @returns true if all axes do.
  bool refine(const std::vector<AxisResolution>& resolution) {
    const double share = kShare * options_.tolerance;
    bool fine = true;
    if (resolution[0].coefficients > share) {
      fine = false;
      state_.time_elements += std::max(1, state_.time_elements / 2);
    }
    for (std::size_t k = 0; k < state_.nodes.size(); ++k) {
      if (problem_.parameters[k].nodes || !(resolution[k + 1].coefficients > share)) continue;
      fine = false;
      state_.nodes[k] += std::max(2, state_.nodes[k] / 2);
    }
    return fine;
  }

  bool finished(AdaptiveResult& result, bool done) const {
    const auto end = [&](AdaptiveStatus status, std::string message) {
      result.status = status;
      result.message = std::move(message);
      return true;
    };
    if (result.evolution.status != EvolutionStatus::converged) {
      return end(AdaptiveStatus::evolution_failed, result.evolution.message);
    }
    if (done) {
      return end(AdaptiveStatus::converged,
                 fmt::format("{} rounds of refinement; {}", state_.round, result.evolution.message));
    }
    const long evaluations = state_.rhs_evaluations + state_.jacobian_evaluations;
    if (options_.max_evaluations > 0 && evaluations >= options_.max_evaluations) {
      return end(AdaptiveStatus::max_evaluations,
                 fmt::format("{} evaluations used, {} allowed", evaluations, options_.max_evaluations));
    }
    const bool too_fine =
        state_.time_elements > options_.max_time_elements ||
        std::any_of(state_.nodes.begin(), state_.nodes.end(), [&](int n) { return n > options_.max_nodes; });
    if (too_fine || state_.round >= options_.max_rounds) {
      return end(
          AdaptiveStatus::not_resolved,
          fmt::format("the axes do not resolve the solution: {:.3g} of its scale is left after {} rounds",
                      state_.coarseness, state_.round));
    }
    return false;
  }

  const AdaptiveProblem& problem_;
  const AdaptiveOptions& options_;
  SolverState state_;
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
  if (problem.scale_floors.size() != problem.states.size()) {
    throw ArgumentError(
        fmt::format("{} scale floors for {} states", problem.scale_floors.size(), problem.states.size()));
  }
  for (const AdaptiveAxis& axis : problem.parameters) check_axis(axis);
  return AdaptiveSolver(problem, options, std::move(start)).run();
}

}  // namespace samara::pgd
