#pragma once

#include <deque>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/evolution/slab_cell.h"
#include "samara/pgd/evolution/slab_evolution.h"
#include "samara/pgd/tensors/random.h"

namespace samara::pgd {

/// The field of a slab of a cell.
struct MarchPiece {
  int cell = 0;
  double end = 0.0;
  TrainField field;
};

/// Between two slabs: all that a march of the same problem, options and tolerances needs to go on to the same
/// end, to the last bit.
struct MarchState {
  std::deque<SlabCell> cells;
  std::vector<MarchPiece> pieces;
  std::vector<SlabRecord> history;
  Random random = Random(0);
  long evaluations = 0;  ///< of all slabs that are done
  double grid_evaluations = 0.0;
  double carried_error = 0.0;
  int left = 0;  ///< slabs whose error is above their share, kept because nothing allowed makes them better
  Eigen::VectorXd smallest, largest;  ///< of every state at the guard points so far, in scales
};

/// As a list of numbers. The state stays as it is.
std::vector<double> archived(MarchState& state, const AdaptiveProblem& problem, const SlabOptions& options);

/// @throws ArgumentError if this is no state of this problem.
MarchState restored(std::span<const double> numbers, const AdaptiveProblem& problem,
                    const SlabOptions& options);

/// Time of a slab: elements of the march's degree between the borders.
Axis slab_axis(const AdaptiveProblem& problem, const std::vector<double>& borders);

}  // namespace samara::pgd
