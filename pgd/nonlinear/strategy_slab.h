#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/termination.h"
#include "samara/pgd/cross/cross_interpolation.h"
#include "samara/pgd/evolution/evolution_problem.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/tensor_train.h"

/// One slab of time as strategies see it.
namespace samara::pgd {

/// Evaluations of f and of its Jacobian, each at one time and one parameter point.
struct StrategyCounts {
  long rhs = 0;
  long jacobian = 0;
};

/// The discretised slab. Time is collocated at s right Radau points; states are over their scales, and time
/// runs from 0 to 1, so that rates are states per slab: all numbers are of the order of one.
///
/// Trains over a slab have a first mode that joins states and time, states first: row m + n i belongs to
/// state m at Radau point i; iterates have the start as time node 0 in front. One mode per parameter axis
/// follows.
class StrategySlab {
 public:
  /// @param problem must outlive the slab; the elements of its time axis are the slabs
  /// @param tolerance of what a slab may add, largest error in scales
  StrategySlab(const EvolutionProblem& problem, int number, TensorTrain start, double tolerance, int max_rank,
               Random& random, StrategyCounts& counts);

  const EvolutionProblem& problem() const { return problem_; }
  int number() const { return number_; }
  int states() const { return static_cast<int>(scales_.size()); }
  int points() const { return static_cast<int>(integration_.rows()); }
  /// states() * points()
  int rows() const { return states() * points(); }
  /// Nodes per parameter axis.
  const std::vector<int>& sizes() const { return sizes_; }
  double begin() const { return begin_; }
  double length() const { return length_; }
  double tolerance() const { return tolerance_; }
  const Eigen::VectorXd& scales() const { return scales_; }
  /// s x s: from values at the Radau points to integrals from the start to them, in slab lengths.
  const Eigen::MatrixXd& integration() const { return integration_; }
  /// The state at the start: its first mode the states.
  const TensorTrain& start() const { return start_; }
  Random& random() const { return random_; }

  /// Parameters (in their units) x entries.
  Eigen::MatrixXd parameters_at(const IndexBatch& entries) const;
  /// Entries of all corners (if there are at most 32), the middle, and `random` random ones.
  IndexBatch training_entries(int random) const;
  IndexBatch random_entries(int count) const;

  /// Rates at the Radau points `nodes`, in scales per slab.
  /// @param x states, over their scales, at these nodes: (states nodes) x entries; @param q parameters x
  /// entries
  Eigen::MatrixXd rates(const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                        const std::vector<int>& nodes) const;
  /// The same at all Radau points.
  Eigen::MatrixXd rates(const Eigen::MatrixXd& x, const Eigen::MatrixXd& q) const;
  /// Jacobians of rates() by x: row (m + n k) + n^2 i is d rate_m / d x_k at Radau point i.
  Eigen::MatrixXd jacobians(const Eigen::MatrixXd& x, const Eigen::MatrixXd& q) const;

  /// Cross interpolation of a function of the parameters.
  /// @param tolerance absolute, for every output @param what in words, for messages
  /// @param pivots taken up and left for the next interpolation of the like
  /// @returns not_finite if a value is not finite, rank_limit if the tolerance is not met.
  Outcome<TensorTrain> separate(const EntryFunction& function, int outputs, double tolerance,
                                CrossPivots& pivots, const char* what) const;
  /// Rounded so that errors stay well below `tolerance` at every entry.
  TensorTrain compressed(TensorTrain train, double tolerance) const;

  /// Entry by entry a * b, compressed at once.
  TensorTrain product(const TensorTrain& a, const TensorTrain& b, double tolerance) const;

  /// The rows of an iterate at the Radau points.
  TensorTrain at_points(const TensorTrain& iterate) const;
  /// The start at every Radau point.
  TensorTrain start_at_points() const;
  /// The iterate that stays at the start.
  TensorTrain constant() const;

  /// Parameters in words.
  std::string described(const std::vector<double>& coordinates) const;

 private:
  const EvolutionProblem& problem_;
  int number_;
  double begin_, length_;
  Eigen::VectorXd scales_;
  Eigen::VectorXd nodes_;  ///< times of the Radau points
  Eigen::MatrixXd integration_;
  std::vector<int> sizes_;
  TensorTrain start_;
  double tolerance_;
  int max_rank_;
  Random& random_;
  StrategyCounts& counts_;
};

/// Selects time rows: matrix of `to` x `from` blocks of `states` rows, block (i, j) the identity where
/// pattern(i, j) is one, in general pattern(i, j) times it.
Eigen::MatrixXd for_all_states(const Eigen::MatrixXd& pattern, int states);

}  // namespace samara::pgd
