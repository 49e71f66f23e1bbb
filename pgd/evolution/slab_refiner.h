#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "samara/base/termination.h"
#include "samara/pgd/evolution/march_context.h"
#include "samara/pgd/evolution/slab_cell.h"
#include "samara/pgd/tensors/random.h"

namespace samara::pgd {

/// What is done where a slab's train is wrong at the guard points.
enum class Refinement {
  same_cell,  ///< more nodes on some axes, or a stricter cross: the slab is tried again
  halves,     ///< the cell is to be split
  shorter,    ///< the slab is to be halved
  none,       ///< nothing that is allowed makes it better: the slab stays as it is
};

/// Decides what a cell needs where its train is wrong: a stricter cross, more nodes, or to be split in two.
class SlabRefiner {
 public:
  explicit SlabRefiner(MarchContext& context) : context_(context) {}

  /// More nodes on the axes that do not resolve the train, or a stricter cross where it is wrong at the nodes
  /// themselves; where that is used up, halves. Slabs on nodes that the problem prescribes, and those of solvers
  /// that are not exact, stay as they are where nothing helps.
  /// @param errors of the train at the guard points @param ranks whether those allowed are used up
  /// @param cells how many there are @returns why the march ends there, if nothing is left to be done
  Outcome<Refinement> refine(SlabCell& cell, const TensorTrain& train, const Eigen::VectorXd& errors,
                             bool ranks, int cells);

  /// Both halves of the cell along the axis that refine() blamed last.
  std::vector<SlabCell> halves(const SlabCell& cell, Random& random) const;

 private:
  struct Blame {
    std::vector<double> by_axis;
    double on_grid = 0.0;
    IndexBatch entries;  ///< nodes next to the worst guard points
  };
  Blame blame(const SlabCell& cell, const TensorTrain& train, const Eigen::VectorXd& errors);
  Refinement of_inexact_solver(SlabCell& cell, double error) const;
  bool add_nodes(SlabCell& cell, const std::vector<double>& by_axis) const;
  Ending unresolved(const SlabCell& cell, const Eigen::VectorXd& errors, bool ranks, int cells) const;

  MarchContext& context_;
  std::size_t coarsest_ = 0;  ///< axis that was blamed last
};

}  // namespace samara::pgd
