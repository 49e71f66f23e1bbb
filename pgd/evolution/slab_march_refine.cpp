#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/evolution/slab_march.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Guard points that are asked which axis is too coarse.
constexpr std::ptrdiff_t kWorstGuards = 8;
/// Of the local tolerance, the error at nodes that is left to the cross.
constexpr double kOnGridShare = 0.7;
/// How far the tolerances of the cross and of rounding may be tightened for a slab.
constexpr double kMostStrict = 0.1;
/// Every refinement raises what a slab may err by this factor, up to the most that any slab may.
constexpr double kLeniency = 1.6;

}  // namespace

/// The errors at the worst guard points, taken apart: with all coordinates but one moved to the nearest
/// nodes, it is what only more nodes on that axis will mend; with all of them moved, what the cross or the
/// rounding has left.
SlabMarch::Blame SlabMarch::blame(const SlabCell& cell, const TensorTrain& train,
                                  const Eigen::VectorXd& errors) {
  std::vector<int> order(static_cast<std::size_t>(errors.size()));
  std::iota(order.begin(), order.end(), 0);
  const auto count = std::min<std::ptrdiff_t>(kWorstGuards, errors.size());
  std::partial_sort(order.begin(), order.begin() + count, order.end(),
                    [&](int a, int b) { return errors[a] > errors[b]; });
  order.resize(static_cast<std::size_t>(count));
  const Eigen::MatrixXd worst = cell.guards(Eigen::all, order);
  const Eigen::Index axes = worst.rows();
  Blame result;
  result.entries.resize(axes, count);
  Eigen::MatrixXd snapped = worst;
  for (Eigen::Index k = 0; k < axes; ++k) {
    const Eigen::VectorXd& nodes = cell.axes[static_cast<std::size_t>(k)].nodes();
    for (Eigen::Index j = 0; j < count; ++j) {
      Eigen::Index nearest = 0;
      (nodes.array() - worst(k, j)).abs().minCoeff(&nearest);
      result.entries(k, j) = static_cast<int>(nearest);
      snapped(k, j) = nodes[nearest];
    }
  }
  Eigen::MatrixXd q = snapped.replicate(1, axes + 1);
  for (Eigen::Index k = 0; k < axes; ++k) q.block(k, k * count, 1, count) = worst.row(k);
  const SlabPoints solved =
      collocation_.solve(cell.slab->borders, values_at(cell.start, cell.axes, q), q, iteration_tolerance());
  attempt_evaluations_ += solved.evaluations;
  const Eigen::MatrixXd difference = (values_at(train, cell.axes, q) - solved.values).cwiseAbs();
  for (Eigen::Index k = 0; k <= axes; ++k) {
    const double error = difference.middleCols(k * count, count).maxCoeff();
    result.by_axis.push_back(std::isfinite(error) ? error : std::numeric_limits<double>::infinity());
  }
  result.on_grid = result.by_axis.back();
  result.by_axis.pop_back();
  return result;
}

/// More nodes on the axes that do not resolve the train, or a stricter cross where it is wrong at the nodes
/// themselves; where that is used up, two cells.
SlabMarch::Outcome SlabMarch::refine(SlabCell& cell, const TensorTrain& train, const Eigen::VectorXd& errors,
                                     bool ranks) {
  cell.leniency = std::min(kLeniency * cell.leniency, most_lenient_);
  const double tolerance = cell.leniency * tolerance_;
  const Blame found = blame(cell, train, errors);
  const std::vector<double>& by_axis = found.by_axis;
  if (found.on_grid > kOnGridShare * tolerance && cell.strictness > kMostStrict) {
    cell.strictness *= 0.3;
    add_entries(cell.pivots, found.entries, options_.max_rank);
    return Outcome::refined;
  }
  std::vector<int> nodes = sizes_of(cell.axes);
  const auto free = [&](std::size_t k) { return !problem_.parameters[k].nodes; };
  const std::size_t coarsest =
      static_cast<std::size_t>(std::max_element(by_axis.begin(), by_axis.end()) - by_axis.begin());
  bool grown = false;
  for (std::size_t k = 0; k < nodes.size() && !ranks; ++k) {
    const bool coarse = k == coarsest || by_axis[k] > 0.5 * tolerance;
    if (!coarse || !free(k) || nodes[k] >= options_.max_nodes) continue;
    nodes[k] = std::min(nodes[k] + std::max(2, nodes[k] / 3), options_.max_nodes);
    grown = true;
  }
  if (grown) {
    resample(cell, problem_, nodes);
    return Outcome::refined;
  }
  const BasisTraits& basis = basis_traits(problem_.parameters[coarsest].basis);
  if (cells() < options_.max_cells && basis.can_be_split()) {
    std::vector<SlabCell> parts =
        halves(cell, problem_, static_cast<int>(coarsest), options_.guards, random_);
    parts[0].number = cell.number;
    parts[1].number = cells();
    // `cell` is an element of the list: it becomes the first half before the second is added.
    cell = std::move(parts[0]);
    cells_.push_back(std::move(parts[1]));
    return Outcome::split;
  }
  Eigen::Index worst = 0;
  const double error = errors.maxCoeff(&worst);
  const Eigen::VectorXd at = cell.guards.col(worst);
  const std::string limit = ranks ? fmt::format("ranks up to {} do not suffice", options_.max_rank)
                                  : fmt::format("{} nodes on the axis {} do not suffice", nodes[coarsest],
                                                cell.axes[coarsest].name());
  return end(
      Termination::not_resolved,
      fmt::format("neighbours part: after t = {:.6g} {}{}, the error at {} is {:.3g} of the range", cell.time,
                  limit, options_.max_cells > 1 ? fmt::format(" in {} cells", cells()) : std::string(),
                  described(cell.axes, {at.begin(), at.end()}), error),
      at);
}

}  // namespace samara::pgd
