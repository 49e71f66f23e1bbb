#include "samara/pgd/evolution/cross_collocation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/evolution/march_context.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Of the local tolerance; rounding has 0.3, time 0.2, the iteration 0.01.
constexpr double kCrossShare = 0.4;

}  // namespace

Outcome<SolvedSlab> CrossCollocation::solve(MarchContext& context, SlabCell& cell, Random& random) {
  SolvedSlab result;
  long entries_solved = 0, iterations = 0;
  const EntryFunction at_entries = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
    SlabPoints points =
        context.solve(cell.slab->borders, values_at(cell.start, entries), coordinates_at(cell.axes, entries));
    entries_solved += entries.cols();
    iterations += points.iterations;
    result.contraction = std::max(result.contraction, points.contraction);
    values = std::move(points.values);
  };
  CrossOptions options;
  options.tolerance = cell.strictness * cell.leniency * kCrossShare * context.tolerance();
  options.max_rank = context.options().max_rank;
  options.guard_entries = context.options().guards;
  options.max_sweeps = 8;
  options.seed = random.bits();
  options.start = cell.pivots;
  CrossResult cross =
      interpolate(at_entries, static_cast<int>(cell.slab->values.rows()), sizes_of(cell.axes), options);
  if (cross.status == Termination::not_finite) {
    return Ending{Termination::not_finite, "the equations could not be solved at a node",
                  coordinates(cell.axes, cross.bad_entry)};
  }
  cell.pivots = std::move(cross.pivots);
  result.iterations = static_cast<double>(iterations) / static_cast<double>(std::max(1L, entries_solved));
  result.grid_evaluations = cross.grid_size * result.iterations * MarchContext::kTimePoints;
  result.train = rounded(cross.train, cell.strictness * context.rounding(cell, cross.train));
  return result;
}

}  // namespace samara::pgd
