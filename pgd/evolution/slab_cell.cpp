#include "samara/pgd/evolution/slab_cell.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/evolution/slab_train.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

std::vector<Axis> axes_with(const AdaptiveProblem& problem, const std::vector<Axis>& intervals,
                            const std::vector<int>& nodes) {
  std::vector<Axis> axes;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    AdaptiveAxis axis = problem.parameters[k];
    axis.lower = intervals[k].lower();
    axis.upper = intervals[k].upper();
    axes.push_back(make_axis(axis, nodes[k]));
  }
  return axes;
}

/// Whether the functions on the axis hold its own coordinate. Under a transform, or periodic, they do not.
bool holds_its_coordinate(const AdaptiveAxis& axis) {
  return axis.label.transform == Transform::none && axis.basis != Basis::fourier;
}

bool starts_exactly(const AdaptiveProblem& problem, const InitialValue& start) {
  return start.axis < 0 || holds_its_coordinate(problem.parameters[static_cast<std::size_t>(start.axis)]);
}

/// The start of the cell on other axes. What only interpolates the starts of states is made anew at t = 0.
TensorTrain start_on(const std::vector<Axis>& axes, const SlabCell& cell, const AdaptiveProblem& problem,
                     const Eigen::VectorXd& scales) {
  const bool is_exact = std::ranges::all_of(
      problem.initial, [&](const InitialValue& start) { return starts_exactly(problem, start); });
  return cell.time > 0.0 || is_exact ? carried_over(cell.start, cell.axes, axes)
                                     : initial_train(problem.initial, scales, axes);
}

}  // namespace

Eigen::MatrixXd starts_at(const SlabCell& cell, const AdaptiveProblem& problem, const Eigen::VectorXd& scales,
                          const Eigen::MatrixXd& points) {
  Eigen::MatrixXd values = values_at(cell.start, cell.axes, points);
  if (cell.time > 0.0) return values;
  for (Eigen::Index s = 0; s < values.rows(); ++s) {
    const InitialValue& start = problem.initial[static_cast<std::size_t>(s)];
    if (!starts_exactly(problem, start)) values.row(s) = points.row(start.axis) / scales[s];
  }
  return values;
}

SlabCell whole_box(const AdaptiveProblem& problem, const Eigen::VectorXd& scales,
                   const std::vector<int>& nodes, int guards, Random& random) {
  SlabCell cell;
  for (std::size_t k = 0; k < nodes.size(); ++k)
    cell.axes.push_back(make_axis(problem.parameters[k], nodes[k]));
  cell.start = initial_train(problem.initial, scales, cell.axes);
  const Eigen::MatrixXd corners = corner_points(cell.axes);
  cell.guards.resize(corners.rows(), corners.cols() + guards);
  cell.guards << corners, random_points(cell.axes, guards, random);
  cell.carried = starts_at(cell, problem, scales, cell.guards);
  return cell;
}

void resample(SlabCell& cell, const AdaptiveProblem& problem, const Eigen::VectorXd& scales,
              const std::vector<int>& nodes) {
  std::vector<Axis> axes = axes_with(problem, cell.axes, nodes);
  cell.start = start_on(axes, cell, problem, scales);
  cell.pivots = carried_over(std::move(cell.pivots), sizes_of(cell.axes), sizes_of(axes));
  cell.axes = std::move(axes);
}

std::vector<SlabCell> halves(const SlabCell& cell, const AdaptiveProblem& problem,
                             const Eigen::VectorXd& scales, int axis, int guards, Random& random) {
  const auto split = static_cast<std::size_t>(axis);
  const Axis& whole = cell.axes[split];
  const double middle = 0.5 * (whole.lower() + whole.upper());
  std::vector<SlabCell> result;
  for (int half = 0; half < 2; ++half) {
    SlabCell part = cell;
    part.pivots = {};
    part.slab.reset();
    AdaptiveAxis interval = problem.parameters[split];
    interval.lower = half == 0 ? whole.lower() : middle;
    interval.upper = half == 0 ? middle : whole.upper();
    part.axes[split] = make_axis(interval, whole.size());
    part.start = start_on(part.axes, cell, problem, scales);
    // Guard points inside keep their states, and with them the error so far; new ones start on the train, or at t = 0
    // where they say: random ones, and corners where the cell was cut.
    std::vector<int> inside;
    for (Eigen::Index j = 0; j < cell.guards.cols(); ++j) {
      if (part.axes[split].contains(cell.guards(axis, j))) inside.push_back(static_cast<int>(j));
    }
    const Eigen::MatrixXd corners = corner_points(part.axes);
    std::vector<int> cut;
    for (Eigen::Index j = 0; j < corners.cols(); ++j) {
      if (corners(axis, j) == middle) cut.push_back(static_cast<int>(j));
    }
    const auto cut_corners = static_cast<Eigen::Index>(cut.size());
    // Corners of many axes are no guards, and a half needs one at least.
    const int drawn = std::max(1, guards / 2);
    Eigen::MatrixXd fresh(corners.rows(), cut_corners + drawn);
    fresh << corners(Eigen::all, cut), random_points(part.axes, drawn, random);
    const auto kept = static_cast<Eigen::Index>(inside.size());
    part.guards.resize(cell.guards.rows(), kept + fresh.cols());
    part.guards << cell.guards(Eigen::all, inside), fresh;
    part.carried.resize(cell.carried.rows(), part.guards.cols());
    part.carried << cell.carried(Eigen::all, inside), starts_at(part, problem, scales, fresh);
    result.push_back(std::move(part));
  }
  return result;
}

}  // namespace samara::pgd
