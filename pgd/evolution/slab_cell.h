#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/evolution/adaptive_problem.h"
#include "samara/pgd/evolution/slab_collocation.h"
#include "samara/pgd/evolution/slab_evolution.h"
#include "samara/pgd/tensors/random.h"

namespace samara::pgd {

/// A slab of a cell as the guard points found it: elements of time that polynomials follow.
struct ProbedSlab {
  std::vector<double> borders;  ///< of the elements
  Eigen::MatrixXd values;       ///< of SlabPoints, at the guard points
  double next_length = 0.0;     ///< proposed for the first element of the next slab

  double end() const { return borders.back(); }
};

/// A cell of the parameter box on its march through time: the state at the start of its next slab.
struct SlabCell {
  std::vector<Axis> axes;
  double time = 0.0;
  double length = 0.0;             ///< of the next element, as proposed by the last
  std::optional<ProbedSlab> slab;  ///< the next one, if it was probed
  TensorTrain start;               ///< states over their scales, then one mode per axis
  CrossPivots pivots;              ///< of the last slab, on these axes
  Eigen::MatrixXd guards;          ///< axes x points: corners of the cell, then random ones
  Eigen::MatrixXd carried;         ///< states x points: those of the guard points, over the scales
  /// Factor on the tolerances of cross and rounding, below one where they have missed something.
  double strictness = 1.0;
  double usual_length = 0.0;  ///< of elements that polynomials follow well
  double leniency = 1.0;      ///< factor on all tolerances of the next slab
  /// Of a solver that is not exact: what it left on the last slab that it could not do better, over the length.
  double rate_of_error = 0.0;
  bool grows_slowly = false;  ///< slabs had to be shortened for the solver
  int number = 0;
};

/// The whole box at t = 0 with the given nodes per axis.
SlabCell whole_box(const AdaptiveProblem& problem, const Eigen::VectorXd& scales,
                   const std::vector<int>& nodes, int guards, Random& random);

/// States over their scales at the start of the next slab, at points (axes x points): those of the train; at t = 0,
/// of states that start at a coordinate under a transform, the coordinate itself, which no train there holds.
Eigen::MatrixXd starts_at(const SlabCell& cell, const AdaptiveProblem& problem, const Eigen::VectorXd& scales,
                          const Eigen::MatrixXd& points);

/// The same state on axes with other numbers of nodes.
void resample(SlabCell& cell, const AdaptiveProblem& problem, const Eigen::VectorXd& scales,
              const std::vector<int>& nodes);

/// The two halves of a cell along an axis, each on as many nodes per axis as the cell.
std::vector<SlabCell> halves(const SlabCell& cell, const AdaptiveProblem& problem,
                             const Eigen::VectorXd& scales, int axis, int guards, Random& random);

}  // namespace samara::pgd
