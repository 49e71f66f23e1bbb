#pragma once

#include <span>
#include <string>

#include "samara/base/termination.h"
#include "samara/pgd/evolution/slab_cell.h"
#include "samara/pgd/evolution/slab_evolution.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/tensor_train.h"

namespace samara::pgd {

class MarchContext;

/// The equations of a slab solved at all nodes of its cell.
struct SolvedSlab {
  TensorTrain train;              ///< first mode as slab_train.h has it, start included
  double contraction = 0.0;       ///< largest ratio of successive corrections
  double iterations = 0.0;        ///< mean over what was solved
  double grid_evaluations = 0.0;  ///< of f, that the same iterations at all nodes would take
};

/// How the equations of a slab are solved: what a march in slabs leaves open. All the rest, how long slabs are,
/// nodes, cells, and what the error is, is the march's.
class SlabSolver {
 public:
  virtual ~SlabSolver() = default;
  virtual std::string name() const = 0;
  /// Elements of time that a slab may have.
  virtual int max_elements() const = 0;
  /// Whether its error at the nodes falls below any bound when it is asked for less. Of others the march keeps
  /// slabs that nothing makes better, and says so.
  virtual bool is_exact() const = 0;
  /// @param cell its elements of time are known; pivots of the cell are taken up and left for the next slab
  /// @returns the train, wrong by less than the tolerance that the context and the cell ask for; or why it was
  /// not found: then the slab is shortened, unless the reason is max_calls or cancelled. What is kept between
  /// slabs must not change the result: marches that are taken up again begin without it.
  virtual Outcome<SolvedSlab> solve(MarchContext& context, SlabCell& cell, Random& random) = 0;
};

/// solve_by_slabs() with another solver of slabs than collocation.
SlabResult solve_by_slabs(const AdaptiveProblem& problem, SlabSolver& solver, const SlabOptions& options = {},
                          std::span<const double> state = {});

}  // namespace samara::pgd
