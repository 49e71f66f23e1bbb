#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/progress.h"
#include "samara/base/termination.h"
#include "samara/pgd/tensors/index_batch.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/tensor_train.h"

/// Cross interpolation: a function on a grid, approximated as a train from values at chosen entries only.
///
/// One core after the other is interpolated on the fibres through index sets that are improved by maximal
/// volume (Goreinov et al. 2010; Oseledets and Tyrtyshnikov, TT-cross approximation, 2010). Ranks grow by
/// pivots: in every sweep a few random indices and the worst of a set of random guard entries, which the
/// builder did not choose, are added to the sets. The approximation counts as converged only when fresh guard
/// entries agree with it.
namespace samara::pgd {

/// Fills values(m, j) with output m at entry j of the batch. Any callable; it is asked for an entry once, unless
/// there are more than can be remembered (entry_table.h).
using EntryFunction = std::function<void(const IndexBatch& entries, Eigen::MatrixXd& values)>;

/// Right index sets of the cores, to start the next approximation of a similar function on the same grid
/// from.
struct CrossPivots {
  std::vector<IndexBatch> right;  ///< right[k]: modes right of core k x rank
};

/// Adds grid entries (modes x entries) to the right sets that there are, up to `max_rank` indices in each.
void add_entries(CrossPivots& pivots, const IndexBatch& entries, int max_rank);

/// The same sets on a grid of other sizes: the nodes at the same places.
CrossPivots carried_over(CrossPivots pivots, const std::vector<int>& from, const std::vector<int>& to);

/// Between two sweeps: what an interpolation that was interrupted goes on from.
struct CrossState {
  CrossPivots pivots;  ///< what was added for the next sweep included
  Random random{0};
  int sweeps = 0;
  long evaluations = 0;
  double largest = 0.0;

  template <class Archive>
  void transfer(Archive& archive) {
    archive(pivots.right, random, sweeps, evaluations, largest);
  }
};

struct CrossOptions {
  /// Absolute, for every output at every guard entry.
  double tolerance = 1e-6;
  int max_rank = 100;
  int max_sweeps = 20;
  int guard_entries = 200;  ///< fresh ones in every sweep
  int first_pivots = 4;     ///< random ones, beside those of `start`
  /// By which part of its size a set grows in every sweep, half by random indices and half by the worst guard
  /// entries; at least by two and four.
  double growth = 0.0;
  long max_evaluations = 50'000'000;
  std::uint64_t seed = 1;
  CrossPivots start = {};  ///< empty: random
  /// An entry gives all outputs: left sets are at few places then, which takes fewer entries, and higher ranks, as
  /// coefficients may be four times as large (max_volume()). For functions of which entries are dear.
  bool few_places = false;
  /// Told the state between sweeps. Entries are then forgotten, so that an interpolation that goes on from there asks
  /// for the same ones, and gives the same to the last bit.
  std::function<void(CrossState&)> checkpoint = {};
  /// Told before, of the same function, sizes and options.
  std::optional<CrossState> state = {};
};

struct CrossResult {
  TensorTrain train;                                 ///< first mode: the outputs, then the grid's modes
  Termination status = Termination::max_iterations;  ///< converged, max_iterations, max_calls or not_finite
  std::string message = "interpolate() was not called";
  double guard_error = 0.0;  ///< largest difference on the last guard entries
  double largest = 0.0;      ///< largest |value| seen
  long evaluations = 0;      ///< entries evaluated, guard included
  double grid_size = 0.0;    ///< entries of the whole grid
  int sweeps = 0;
  CrossPivots pivots;
  std::vector<int> bad_entry;  ///< where a value was not finite, if one was
};

/// @param sizes nodes per mode, at least one mode
/// @throws ArgumentError if sizes or options are out of range, or the start's pivots are not on this grid.
CrossResult interpolate(const EntryFunction& function, int outputs, const std::vector<int>& sizes,
                        const CrossOptions& options);

}  // namespace samara::pgd
