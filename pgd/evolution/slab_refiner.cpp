#include "samara/pgd/evolution/slab_refiner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/axes/basis.h"
#include "samara/pgd/cross/nodal_approximation.h"
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
/// Half the slab is worth its work if it leaves less than this part of the error in the same time.
constexpr double kWorthwhile = 0.75;

}  // namespace

/// The errors at the worst guard points, taken apart: with all coordinates but one moved to the nearest
/// nodes, it is what only more nodes on that axis will mend; with all of them moved, what the cross or the
/// rounding has left.
SlabRefiner::Blame SlabRefiner::blame(const SlabCell& cell, const TensorTrain& train,
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
      context_.solve(cell.slab->borders, starts_at(cell, context_.problem(), context_.scales(), q), q);
  const Eigen::MatrixXd difference = (values_at(train, cell.axes, q) - solved.values).cwiseAbs();
  for (Eigen::Index k = 0; k <= axes; ++k) {
    const double error = difference.middleCols(k * count, count).maxCoeff();
    result.by_axis.push_back(std::isfinite(error) ? error : std::numeric_limits<double>::infinity());
  }
  result.on_grid = result.by_axis.back();
  result.by_axis.pop_back();
  return result;
}

/// On the axes that are too coarse, as far as the problem and the options allow. @returns whether any got more
bool SlabRefiner::add_nodes(SlabCell& cell, const std::vector<double>& by_axis) const {
  const int most = context_.options().max_nodes;
  std::vector<int> nodes = sizes_of(cell.axes);
  bool grown = false;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const bool coarse = k == coarsest_ || by_axis[k] > 0.5 * cell.leniency * context_.tolerance();
    if (!coarse || context_.problem().parameters[k].nodes || nodes[k] >= most) continue;
    nodes[k] = std::min(nodes[k] + std::max(2, nodes[k] / 3), most);
    grown = true;
  }
  if (grown) resample(cell, context_.problem(), context_.scales(), nodes);
  return grown;
}

Outcome<Refinement> SlabRefiner::refine(SlabCell& cell, const TensorTrain& train,
                                        const Eigen::VectorXd& errors, bool ranks, int cells) {
  const SlabOptions& options = context_.options();
  cell.leniency = std::min(kLeniency * cell.leniency, context_.most_lenient());
  const Blame found = blame(cell, train, errors);
  const bool wrong_on_grid = found.on_grid > kOnGridShare * cell.leniency * context_.tolerance();
  if (wrong_on_grid && cell.strictness > kMostStrict) {
    cell.strictness *= 0.3;
    add_entries(cell.pivots, found.entries, options.max_rank);
    return Refinement::same_cell;
  }
  if (wrong_on_grid && !context_.solver().is_exact()) return of_inexact_solver(cell, errors.maxCoeff());
  coarsest_ = static_cast<std::size_t>(std::max_element(found.by_axis.begin(), found.by_axis.end()) -
                                       found.by_axis.begin());
  if (!ranks && add_nodes(cell, found.by_axis)) return Refinement::same_cell;
  if (cells < options.max_cells &&
      basis_traits(context_.problem().parameters[coarsest_].basis).can_be_split())
    return Refinement::halves;
  if (!ranks && context_.problem().parameters[coarsest_].nodes) return Refinement::none;
  return unresolved(cell, errors, ranks, cells);
}

/// Shorter slabs as long as the error falls faster than the length.
Refinement SlabRefiner::of_inexact_solver(SlabCell& cell, double error) const {
  const double length = cell.slab->end() - cell.time;
  const double before = std::exchange(cell.rate_of_error, error / length);
  const bool falls = before == 0.0 || cell.rate_of_error < kWorthwhile * before;
  return falls && 0.5 * length >= context_.shortest() ? Refinement::shorter : Refinement::none;
}

std::vector<SlabCell> SlabRefiner::halves(const SlabCell& cell, Random& random) const {
  return pgd::halves(cell, context_.problem(), context_.scales(), static_cast<int>(coarsest_),
                     context_.options().guards, random);
}

Ending SlabRefiner::unresolved(const SlabCell& cell, const Eigen::VectorXd& errors, bool ranks,
                               int cells) const {
  const SlabOptions& options = context_.options();
  Eigen::Index worst = 0;
  const double error = errors.maxCoeff(&worst);
  const Eigen::VectorXd at = cell.guards.col(worst);
  const Axis& axis = cell.axes[coarsest_];
  const std::string limit =
      ranks ? fmt::format("ranks up to {} do not suffice", options.max_rank)
            : fmt::format("{} nodes on the axis {} do not suffice", axis.size(), axis.name());
  return {
      Termination::not_resolved,
      fmt::format("neighbours part: after t = {:.6g} {}{}, the error at {} is {:.3g} of the range", cell.time,
                  limit, options.max_cells > 1 ? fmt::format(" in {} cells", cells) : std::string(),
                  described(cell.axes, {at.begin(), at.end()}), error),
      {at.begin(), at.end()}};
}

}  // namespace samara::pgd
