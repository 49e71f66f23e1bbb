#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/progress.h"
#include "samara/base/termination.h"
#include "samara/pgd/cross/cross_interpolation.h"
#include "samara/pgd/evolution/adaptive_problem.h"
#include "samara/pgd/fields/train_field.h"

/// Separated solutions of strongly nonlinear parametric evolution equations, slab by slab in time.
///
///   x' = f(t, x, q),  x(0) = x0(q),  q in a box.
///
/// The state at the start of a slab is a train over the parameters. On the slab the equations are collocated
/// in time, and the collocation's solution, a function of the parameters, is interpolated by crosses: at the
/// parameter entries that the cross asks for, and only there, f is evaluated and the slab's equations are
/// solved. The train is rounded, and its end starts the next slab. Slabs have a few elements of time, each as
/// long as a polynomial of the given degree follows the motion; parameter axes get more nodes when random
/// points off the grid disagree; where nodes or ranks run out, the box is split, and each cell goes on by
/// itself. No trajectory enters the solution.
///
/// A small set of random *guard* points per cell carries its own states from slab to slab: what separates
/// them from the train is the error of the train, accumulated and amplified as the motion does it. The march
/// is repeated with smaller tolerances until that error meets the wanted one.
namespace samara::pgd {

struct SlabOptions {
  /// Wanted largest error over the box, in ranges of the states.
  double tolerance = 1e-4;
  int max_elements = 8;  ///< of a slab
  /// The longest slab of more than one element, as a part of the whole time.
  double joint_slab = 0.03;
  int first_nodes = 7;
  int max_nodes = 96;  ///< of a parameter axis in a cell
  int max_rank = 120;
  int max_cells = 1;
  int guards = 64;  ///< per cell; the corners of the cell are added to them
  int max_marches = 4;
  long max_evaluations = 0;  ///< of f and J; 0: no limit
  std::uint64_t seed = 1;
  ProgressCallback progress = {};
  /// Called between slabs, at most a twentieth of the time, with a state that solve_by_slabs() goes on from
  /// to the same result, to the last bit.
  std::function<void(const std::vector<double>& state)> checkpoint = {};
};

/// What one slab of one cell took.
struct SlabRecord {
  int cell = 0;
  double begin = 0.0;
  double end = 0.0;
  int elements = 0;  ///< of time
  std::vector<int> nodes;
  std::vector<int> ranks;
  double contraction = 0.0;     ///< largest ratio of successive corrections
  double iterations = 0.0;      ///< mean over the entries solved
  double local_error = 0.0;     ///< at the guard points, of this slab alone, in ranges
  double carried_error = 0.0;   ///< at the guard points, since the start
  long evaluations = 0;         ///< of f, refused attempts and guard points included
  double grid_evaluations = 0;  ///< what the same iterations at all nodes of this slab's grid would take
  double seconds = 0.0;
};

struct SlabResult {
  /// One field per slab and cell, over time and the parameters, outputs the states, SI; ascending in time
  /// within a cell. If the march ended early, all cells reach the same time `reached`.
  std::vector<TrainField> pieces;
  /// converged; missed: solved to the end, but the error at the guard points is above the tolerance; ceases,
  /// no_contraction, not_resolved, not_finite, max_calls or cancelled: the march ended at `reached`. By strategies
  /// (march.h) also diverged, max_iterations or rank_limit, on the shortest slab that is allowed.
  Termination status = Termination::missed;
  std::string message;
  double reached = 0.0;
  std::vector<SlabRecord> history;  ///< of the last march
  int marches = 0;
  int cells = 1;
  double error = 0.0;          ///< largest carried error of the last march, in ranges
  std::vector<double> ranges;  ///< of the states, as the guard points saw them
  /// Where the march ended early: the parameters. Empty otherwise.
  std::vector<double> where;
  long evaluations = 0;         ///< of f and J, all marches
  double grid_evaluations = 0;  ///< of the same iterations on the full grids
  double seconds = 0.0;
};

/// @throws ArgumentError if the problem or the options are outside their meaning: what every march asks first.
void check_march(const AdaptiveProblem& problem, const SlabOptions& options);

/// @param state of a call with the same problem and options that was cut off; empty: from the start
/// @throws ArgumentError if problem or options do not validate, or the state is not of this problem and these
/// options.
SlabResult solve_by_slabs(const AdaptiveProblem& problem, const SlabOptions& options = {},
                          std::span<const double> state = {});

}  // namespace samara::pgd
