#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "samara/pgd/cross/cross_interpolation.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/tensor_train.h"

namespace samara::codebooks {

/// What a build goes on from: before a round, between two sweeps of its cross, or before its field is judged.
struct SteppedState {
  std::vector<double> times;  ///< nodes of the axis of time, as the build has chosen them
  int round = 1;
  double cross_share = 0.0, node_share = 0.0, element_share = 0.0;
  pgd::Random random{0};  ///< as it was before the round, or after the cross
  long calls = 0;
  pgd::CrossPivots pivots;  ///< of the last cross, as are the nodes
  std::vector<int> nodes;
  std::vector<pgd::CrossState> sweep;  ///< one, if a sweep of the round is done
  bool is_crossed = false;             ///< the cross of the round is done, and left what follows
  double error = 0.0, guard_error = 0.0;
  bool are_ranks_used_up = false;
  pgd::TensorTrain best;
  double best_error = 0.0;
  std::vector<int> nodes_of_best;

  template <class Archive>
  void transfer(Archive& archive) {
    archive(times, round, cross_share, node_share, element_share, random, calls, pivots.right, nodes);
    auto sweeps = sweep.size();
    archive(sweeps);
    sweep.resize(std::min<std::size_t>(sweeps, 1));
    for (pgd::CrossState& state : sweep) state.transfer(archive);
    archive(is_crossed, error, guard_error, are_ranks_used_up, best, best_error, nodes_of_best);
  }

  /// Whether what is told of a cross and of the best field lies on grids over so many coordinates.
  /// @param rows of the first core of the field: states at times
  /// @param nodes_of_round those of the sweep
  bool fits(std::size_t coordinates, std::size_t rows, const std::vector<int>& nodes_of_round) const;
};

}  // namespace samara::codebooks
