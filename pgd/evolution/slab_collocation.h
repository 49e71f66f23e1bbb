#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/termination.h"
#include "samara/pgd/evolution/evolution_problem.h"

namespace samara::pgd {

/// Polynomials in time on one element of a slab, mapped to [0, 1]: through the start and s right Radau
/// points, the last of which is the end. Collocation there is the method Radau IIA of order 2s - 1 at the end
/// (Hairer and Wanner, Solving ODEs II, section IV.5).
struct SlabTime {
  explicit SlabTime(int points);

  int points() const { return static_cast<int>(integration.rows()); }
  Eigen::VectorXd nodes;        ///< the start and the s points
  Eigen::MatrixXd integration;  ///< s x s: from values at the points to integrals from 0 to them
  Eigen::MatrixXd at_halves;    ///< 2 s x (s + 1): from the nodes to the s points of either half
};

/// I - S J of one element. @param integration over its length @param jacobians column j: df/dx at point j,
/// column after column
Eigen::MatrixXd collocation_matrix(const Eigen::MatrixXd& integration,
                                   const Eigen::Ref<const Eigen::MatrixXd>& jacobians);

/// Solutions of x' = f(t, x, q) on a slab of one or more elements, each at its own q.
struct SlabPoints {
  /// Row m + states * i: state m, over its scale, at node i of the slab (elements * s + 1 of them). One
  /// column per point; NaN from where a point was not solved.
  Eigen::MatrixXd values;
  std::vector<Termination> status;  ///< of each point: converged, no_contraction or not_finite
  long evaluations = 0;             ///< of f (and of J, counted once for every time node)
  long iterations = 0;              ///< summed over the points
  double contraction = 0.0;         ///< largest ratio of successive corrections

  /// First point that was not solved, or -1.
  int first_failed() const;
};

/// Collocation at single parameter points, many at once. Picard's iteration; where it does not contract,
/// Newton's. Results do not depend on the number of threads.
class SlabCollocation {
 public:
  /// @param scales of the states, positive. The system must outlive the object.
  SlabCollocation(const EvolutionSystem& system, Eigen::VectorXd scales, int time_points);

  int states() const { return static_cast<int>(scales_.size()); }
  const SlabTime& time() const { return time_; }
  const Eigen::VectorXd& scales() const { return scales_; }

  /// @param borders of the elements, ascending, at least two
  /// @param start states x points, over their scales; @param q parameters x points
  /// @param tolerance of the iteration, in scales
  SlabPoints solve(const std::vector<double>& borders, const Eigen::MatrixXd& start, const Eigen::MatrixXd& q,
                   double tolerance) const;

 private:
  struct Chunk;
  void load(Chunk& chunk, const std::vector<int>& points) const;
  void solve_element(Chunk& chunk, double tolerance) const;
  void picard(Chunk& chunk, double tolerance) const;
  void newton(Chunk& chunk, double tolerance) const;
  void store(Chunk& chunk, int point, const Eigen::Ref<const Eigen::MatrixXd>& x) const;

  const EvolutionSystem& system_;
  Eigen::VectorXd scales_;
  SlabTime time_;
};

}  // namespace samara::pgd
