#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/termination.h"
#include "samara/pgd/evolution/march_context.h"
#include "samara/pgd/evolution/march_state.h"
#include "samara/pgd/evolution/slab_refiner.h"
#include "samara/pgd/evolution/time_stepper.h"

namespace samara::pgd {

/// One march of all cells from t = 0 to the end at one local tolerance.
class SlabMarch {
 public:
  /// @param scales what errors are measured in
  /// @param evaluations_before of f and J, which count for the limit of the options
  SlabMarch(const AdaptiveProblem& problem, const SlabOptions& options, SlabSolver& solver,
            const Eigen::VectorXd& scales, LocalTolerance tolerance, long evaluations_before);

  /// @param between_slabs called after every slab
  void run(const std::function<void()>& between_slabs = {});

  /// Between two slabs: see MarchState.
  std::vector<double> state();
  /// @throws ArgumentError if this is no state of this problem.
  void restore(std::span<const double> state);

  const std::vector<MarchPiece>& pieces() const { return state_.pieces; }
  const std::vector<SlabRecord>& history() const { return state_.history; }
  /// Why the march ended before every cell has reached the end, if it did.
  const std::optional<Ending>& ending() const { return ending_; }
  Termination status() const { return ending_ ? ending_->status : Termination::converged; }
  /// Time that all cells have reached.
  double reached() const { return reached_; }
  int cells() const { return static_cast<int>(state_.cells.size()); }
  long evaluations() const { return state_.evaluations + context_.evaluations(); }
  double grid_evaluations() const { return state_.grid_evaluations; }
  /// Slabs whose error is above their share, kept because nothing allowed makes them better.
  int left() const { return state_.left; }
  double carried_error() const { return state_.carried_error; }
  /// Largest minus smallest value of every state at the guard points so far, in scales.
  Eigen::VectorXd ranges() const { return state_.largest - state_.smallest; }

 private:
  std::optional<Ending> reason_to_stop(const SlabCell& first);
  Ending out_of_evaluations(const SlabCell& cell) const;
  std::optional<Ending> attempt(SlabCell& cell);
  std::optional<Ending> shorten(SlabCell& cell, const Ending& why);
  Outcome<Refinement> refine(SlabCell& cell, const TensorTrain& train, const Eigen::VectorXd& errors);
  void split(SlabCell& cell);
  void accept(SlabCell& cell, const SolvedSlab& solved, double error);
  double carry_on(SlabCell& cell, const TensorTrain& train);

  SlabSolver& solver_;
  MarchContext context_;
  TimeStepper stepper_;
  SlabRefiner refiner_;
  const long evaluations_before_;
  MarchState state_;
  std::optional<Ending> ending_;
  double reached_ = 0.0;
  std::chrono::steady_clock::time_point attempt_begin_;
};

}  // namespace samara::pgd
