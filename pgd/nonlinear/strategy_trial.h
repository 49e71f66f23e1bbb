#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "samara/base/progress.h"
#include "samara/pgd/fields/train_field.h"
#include "samara/pgd/nonlinear/strategy.h"

/// What a strategy does by itself, on slabs and nodes that are given: every iteration is recorded. For looking at
/// strategies; solutions come from march() (march.h), which chooses slabs and nodes and measures the error.
///
///   const auto strategy = cross_strategy();
///   const StrategyTrial result = try_strategy(problem, *strategy, {.tolerance = 1e-6});
///   if (result.status != Termination::converged) report(result.message);
///   result.value_at(x);  // x: time, then the parameters
namespace samara::pgd {

struct StrategyTrialOptions {
  /// Of every slab, largest error in scales at its nodes. What too few nodes leave, and what a strategy
  /// leaves out by nature, comes on top: see StrategyRecord::defect.
  double tolerance = 1e-6;
  int max_iterations = 40;
  int max_rank = 120;
  /// A strategy that gives the first iterate of every slab, by two of its iterations; on slabs on which it
  /// fails, the start is the first iterate.
  Strategy* first = nullptr;
  /// Of f and J, preparation included; no iteration begins beyond it. 0: no limit.
  long max_evaluations = 0;
  std::uint64_t seed = 1;
  ProgressCallback progress = {};
};

/// What one slab took.
struct StrategyRecord {
  double begin = 0.0;
  double end = 0.0;
  Termination status = Termination::max_iterations;
  int iterations = 0;
  /// ||X_k+1 - X_k||, root mean square over the nodes of the box, in scales.
  std::vector<double> corrections = {};
  /// Largest ratio of successive corrections that were above the tolerance; 0: there was none.
  double contraction = 0.0;
  /// |x0 + S f(X) - X|, largest at random points off the grid, in scales: what is left of the equations
  /// themselves.
  double defect = 0.0;
  std::vector<int> ranks = {};           ///< of the solution
  std::vector<int> source_ranks = {};    ///< of b, largest over the iterations
  std::vector<int> jacobian_ranks = {};  ///< of A; empty: there was none
  long rhs_evaluations = 0;
  long jacobian_evaluations = 0;
  /// Evaluations of f that the same iterations at all nodes would take.
  double grid_evaluations = 0.0;
  std::optional<StrategyDetail> detail = {};  ///< of the strategy, on this slab
  double seconds = 0.0;
};

struct StrategyTrial {
  /// One per slab that was solved, over time and the parameters, outputs the states, SI.
  std::vector<TrainField> pieces;
  /// converged, or what ended the march: max_iterations, diverged, not_finite, rank_limit, max_calls, cancelled.
  Termination status = Termination::max_iterations;
  std::string message = "try_strategy() was not called";
  std::vector<double> where;            ///< parameters at which the march failed, if it is known
  double reached = 0.0;                 ///< end of the last piece
  std::vector<StrategyRecord> history;  ///< one per slab, the failed one included
  long rhs_evaluations = 0;             ///< those of the strategy's preparation included
  long jacobian_evaluations = 0;
  double grid_evaluations = 0.0;
  double seconds = 0.0;

  int largest_rank() const;
  int largest_iterations() const;
  double largest_contraction() const;
  double largest_defect() const;
  /// States at (time, parameters..). @throws ArgumentError if the time is not covered.
  Eigen::VectorXd value_at(std::span<const double> x) const;
};

/// Marches over the elements of the problem's time axis, which must be of the radau kind. Ends at the first
/// slab on which the strategy fails, with what is valid before it.
/// @throws ArgumentError if problem or options do not validate, or there is no parameter axis.
StrategyTrial try_strategy(const EvolutionProblem& problem, Strategy& strategy,
                           const StrategyTrialOptions& options = {});

}  // namespace samara::pgd
