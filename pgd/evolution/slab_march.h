#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/evolution/slab_cell.h"
#include "samara/pgd/evolution/slab_collocation.h"
#include "samara/pgd/evolution/slab_evolution.h"
#include "samara/pgd/tensors/random.h"

namespace samara::pgd {

/// What a slab may add to the error, in scales: slabs with features that no polynomial follows, which are
/// few, may err by more than the smooth ones, which are many and cost little.
struct LocalTolerance {
  double wanted = 0.0;
  double largest = 0.0;
};

/// One march of all cells from t = 0 to the end at one local tolerance.
class SlabMarch {
 public:
  /// @param scales what errors are measured in
  /// @param evaluations_left of f and J; negative: no limit
  SlabMarch(const AdaptiveProblem& problem, const SlabOptions& options, const Eigen::VectorXd& scales,
            LocalTolerance tolerance, long evaluations_left);

  /// @param between_slabs called after every slab
  void run(const std::function<void()>& between_slabs = {});

  /// Between two slabs: all that a march of the same problem, options and tolerances needs to go on to the
  /// same end, to the last bit.
  std::vector<double> state();
  /// @throws ArgumentError if this is no state of this problem.
  void restore(std::span<const double> state);

  struct Piece {
    int cell = 0;
    double end = 0.0;
    TrainField field;
  };
  const std::vector<Piece>& pieces() const { return pieces_; }
  const std::vector<SlabRecord>& history() const { return history_; }
  /// converged if every cell has reached the end.
  Termination status() const { return status_; }
  const std::string& message() const { return message_; }
  const std::vector<double>& where() const { return where_; }
  /// Time that all cells have reached.
  double reached() const { return reached_; }
  int cells() const { return static_cast<int>(cells_.size()); }
  long evaluations() const { return evaluations_ + attempt_evaluations_; }
  double grid_evaluations() const { return grid_evaluations_; }
  double carried_error() const { return carried_error_; }
  /// Largest minus smallest value of every state at the guard points so far, in scales.
  Eigen::VectorXd ranges() const { return largest_ - smallest_; }

 private:
  /// What an attempt at a slab came to.
  enum class Outcome { accepted, shorter, refined, split, ended };

  // slab_march.cpp: one slab.
  Outcome attempt(SlabCell& cell);
  struct Totals {
    long entries = 0, evaluations = 0, iterations = 0;
    double contraction = 0.0;
  };
  CrossResult interpolate_slab(SlabCell& cell, Totals& totals);
  double rounding(const SlabCell& cell, const TensorTrain& train) const;
  Axis time_axis(const std::vector<double>& borders) const;
  void accept(SlabCell& cell, const TensorTrain& train, SlabRecord record);
  double carry_on(SlabCell& cell, const TensorTrain& train);
  bool may_go_on(const SlabCell& first);
  void out_of_evaluations(const SlabCell& cell);
  Outcome end(Termination status, std::string message, const Eigen::VectorXd& q);
  /// What iterations may leave, in scales.
  double iteration_tolerance() const { return 0.01 * tolerance_; }

  // slab_march_time.cpp: how long it is.
  struct WorstPoint {
    double error = 0.0;
    Eigen::Index point = 0;
  };
  Outcome probe(SlabCell& cell);
  WorstPoint error_in_time(const SlabPoints& element, double begin, double end, const Eigen::MatrixXd& q);
  Outcome shorten(SlabCell& cell, const std::vector<int>& bad_entry);
  Outcome give_up(const SlabCell& cell, double length, const SlabPoints& points, const Eigen::MatrixXd& q);
  Outcome give_up_on_time(const SlabCell& cell, double length, const Eigen::VectorXd& q);
  Outcome end_at(const SlabCell& cell, Termination status, const char* what, double length,
                 const Eigen::VectorXd& q);
  bool moves_by_its_size(double t, const Eigen::VectorXd& start, const Eigen::VectorXd& q,
                         double length) const;

  // slab_march_refine.cpp: what is done about errors.
  struct Blame {
    std::vector<double> by_axis;
    double on_grid = 0.0;
    IndexBatch entries;  ///< nodes next to the worst guard points
  };
  Blame blame(const SlabCell& cell, const TensorTrain& train, const Eigen::VectorXd& errors);
  Outcome refine(SlabCell& cell, const TensorTrain& train, const Eigen::VectorXd& errors, bool ranks);

  // slab_march_state.cpp
  template <class Archive>
  void transfer_march(Archive& archive);
  template <class Archive>
  void transfer_fields(Archive& archive);

  const AdaptiveProblem& problem_;
  const SlabOptions& options_;
  const Eigen::VectorXd scales_;
  const double tolerance_;  ///< local
  const double most_lenient_;
  const long evaluations_left_;
  SlabCollocation collocation_;
  Random random_;
  std::deque<SlabCell> cells_;
  long attempt_evaluations_ = 0;
  std::chrono::steady_clock::time_point attempt_begin_;

  std::vector<Piece> pieces_;
  std::vector<SlabRecord> history_;
  Termination status_ = Termination::converged;
  std::string message_;
  std::vector<double> where_;
  double reached_ = 0.0;
  long evaluations_ = 0;
  double grid_evaluations_ = 0.0;
  double carried_error_ = 0.0;
  Eigen::VectorXd smallest_, largest_;
};

}  // namespace samara::pgd
