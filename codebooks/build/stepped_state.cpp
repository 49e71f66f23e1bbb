#include "samara/codebooks/build/stepped_state.h"

namespace samara::codebooks {

namespace {

bool are_nodes(const std::vector<int>& nodes, std::size_t coordinates) {
  return nodes.size() == coordinates && std::ranges::all_of(nodes, [](int n) { return n >= 2; });
}

/// Whether right sets hold places of a grid.
bool are_places(const pgd::CrossPivots& pivots, const std::vector<int>& nodes) {
  if (pivots.right.size() != nodes.size() + 1) return false;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const pgd::IndexBatch& set = pivots.right[k];
    if (set.cols() == 0) continue;
    if (set.rows() != static_cast<Eigen::Index>(nodes.size() - k)) return false;
    for (Eigen::Index m = 0; m < set.rows(); ++m) {
      if (set.row(m).minCoeff() < 0 || set.row(m).maxCoeff() >= nodes[k + static_cast<std::size_t>(m)])
        return false;
    }
  }
  return true;
}

/// Whether cores are a train over rows and then these nodes.
bool is_train(const std::vector<pgd::TrainCore>& cores, std::size_t rows, const std::vector<int>& nodes) {
  if (cores.size() != nodes.size() + 1) return false;
  int left = 1;
  for (std::size_t k = 0; k < cores.size(); ++k) {
    const pgd::TrainCore& core = cores[k];
    const std::size_t size = k == 0 ? rows : static_cast<std::size_t>(nodes[k - 1]);
    if (core.left != left || core.size < 0 || static_cast<std::size_t>(core.size) != size || core.right < 1 ||
        core.data.size() != Eigen::Index{core.left} * core.size * core.right)
      return false;
    left = core.right;
  }
  return left == 1;
}

}  // namespace

bool SteppedState::fits(std::size_t coordinates, std::size_t rows,
                        const std::vector<int>& nodes_of_round) const {
  const bool has_cross = !nodes.empty();
  if (has_cross && (!are_nodes(nodes, coordinates) || !are_places(pivots, nodes))) return false;
  if (!sweep.empty() && !are_places(sweep.front().pivots, nodes_of_round)) return false;
  if (best.cores.empty()) return !has_cross && !is_crossed;
  return has_cross && are_nodes(nodes_of_best, coordinates) && is_train(best.cores, rows, nodes_of_best);
}

}  // namespace samara::codebooks
