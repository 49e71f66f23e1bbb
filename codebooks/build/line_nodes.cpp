#include "samara/codebooks/build/line_nodes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/axes/axis_transform.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::codebooks {

namespace {

using Eigen::Index;

/// Lines that are asked for together.
constexpr Index kTogether = 8;

/// Of values along a line, a row each: the largest sums of the sizes of coefficients from each number on.
Eigen::VectorXd tail_of(const Eigen::MatrixXd& values, const Eigen::MatrixXd& transform) {
  Eigen::MatrixXd coefficients = (values * transform.transpose()).cwiseAbs();
  for (Index j = coefficients.cols() - 1; j > 0; --j) coefficients.col(j - 1) += coefficients.col(j);
  return coefficients.colwise().maxCoeff().transpose();
}

/// The fewest nodes after which less than `bound` is left.
int nodes_for(const Eigen::VectorXd& tail, double bound) {
  int nodes = 2;
  while (nodes < tail.size() && tail[nodes] > bound) ++nodes;
  return nodes;
}

}  // namespace

Eigen::MatrixXd chebyshev_transform(int count) {
  const int degree = count - 1;
  const auto end = [&](int i) { return i == 0 || i == degree ? 0.5 : 1.0; };
  Eigen::MatrixXd transform(count, count);
  for (int j = 0; j < count; ++j) {
    for (int i = 0; i < count; ++i) {
      transform(j, i) =
          2.0 / degree * end(i) * end(j) * std::cos(std::numbers::pi * (i * j % (2 * degree)) / degree);
    }
  }
  return transform;
}

std::string described(const Front& front, const std::vector<pgd::Axis::Label>& coordinates,
                      const std::vector<pgd::OutputLabel>& outputs, const std::vector<double>& times,
                      const std::string& time_unit) {
  const auto states = static_cast<Index>(outputs.size());
  std::string at;
  for (std::size_t k = 0; k < coordinates.size(); ++k)
    at += fmt::format("{}{} = {:.4g}", k == 0 ? "" : ", ", coordinates[k].name,
                      front.point[static_cast<Index>(k)]);
  return fmt::format(
      "along {} {} at t = {:.4g} {} changes by its range within {:.2g}, about {}: that takes {} nodes, and "
      "{} err by "
      "{:.2g}",
      coordinates[static_cast<std::size_t>(front.coordinate)].name,
      outputs[static_cast<std::size_t>(front.row % states)].name,
      times[static_cast<std::size_t>(front.row / states)], time_unit, front.width, at,
      front.nodes > 0 ? std::to_string(front.nodes) : fmt::format("more than {}", LineNodes::kMostFront),
      front.allowed, front.error);
}

LineNodes::LineNodes(Index coordinates, AxisOf axis_of, Values values, int max_nodes)
    : axis_of_(std::move(axis_of)),
      values_(std::move(values)),
      max_nodes_(std::max(2, max_nodes)),
      tails_(static_cast<std::size_t>(coordinates)),
      fronts_(tails_.size()),
      elements_(tails_.size()) {}

void LineNodes::look_along(Index coordinate, const Eigen::MatrixXd& bases, double bound, double tolerance) {
  Eigen::VectorXd tail;
  for (int count = 9; count <= kMostLine; count = 2 * count - 1) {
    tail = tail_along(coordinate, bases, count);
    if (nodes_for(tail, bound) < count - 1) break;
    if (count >= max_nodes_) break;
  }
  std::optional<Front> front;
  if (tail[std::min<Index>(max_nodes_, tail.size() - 1)] > tolerance)
    front = front_along(coordinate, bases, tolerance);
  const auto k = static_cast<std::size_t>(coordinate);
  // Behind the last coefficients of a look that needed fewer there is nothing.
  const Index most = std::max(tail.size(), tails_[k].size());
  tail.conservativeResizeLike(Eigen::VectorXd::Zero(most));
  tails_[k].conservativeResizeLike(Eigen::VectorXd::Zero(most));
  tails_[k] = tails_[k].cwiseMax(tail);
  if (front && (!fronts_[k] || fronts_[k]->error < front->error)) fronts_[k] = std::move(front);
}

std::vector<int> LineNodes::within(double bound) const {
  std::vector<int> nodes;
  for (std::size_t k = 0; k < tails_.size(); ++k)
    nodes.push_back(elements_[k].empty() ? std::clamp(nodes_for(tails_[k], bound), 2, max_nodes_)
                                         : elements_[k].back().size());
  return nodes;
}

bool LineNodes::needs_more(Index coordinate, double bound) const {
  return nodes_for(tails_[static_cast<std::size_t>(coordinate)], bound) > max_nodes_;
}

void LineNodes::set_elements(Index coordinate, pgd::Axis axis) {
  elements_[static_cast<std::size_t>(coordinate)].push_back(std::move(axis));
}

const pgd::Axis* LineNodes::elements(Index coordinate) const {
  const std::vector<pgd::Axis>& axes = elements_[static_cast<std::size_t>(coordinate)];
  return axes.empty() ? nullptr : &axes.back();
}

bool LineNodes::has_elements() const {
  return std::ranges::any_of(elements_, [](const auto& axes) { return !axes.empty(); });
}

pgd::Axis LineNodes::axis(Index coordinate, int nodes) const {
  for (const pgd::Axis& axis : elements_[static_cast<std::size_t>(coordinate)]) {
    if (axis.size() == nodes) return axis;
  }
  return axis_of_(coordinate, nodes);
}

const Front* LineNodes::front() const {
  const Front* worst = nullptr;
  for (std::size_t k = 0; k < fronts_.size(); ++k) {
    if (fronts_[k] && elements_[k].empty() && (worst == nullptr || worst->error < fronts_[k]->error))
      worst = &*fronts_[k];
  }
  return worst;
}

/// Those of an axis, which with many of them takes seconds to make.
Eigen::VectorXd LineNodes::nodes_of(Index coordinate, int count) const {
  const pgd::Axis ends = axis_of_(coordinate, 2);
  const double length = pgd::transformed_distance(ends.transform(), ends.lower(), ends.upper());
  Eigen::VectorXd nodes(count);
  for (int i = 0; i < count; ++i) {
    const double share = std::sin(0.5 * std::numbers::pi * i / (count - 1));
    nodes[i] = pgd::transformed_advance(ends.transform(), ends.lower(), length * share * share);
  }
  nodes[count - 1] = ends.upper();
  return nodes;
}

/// Points along all lines, line by line.
Eigen::MatrixXd LineNodes::lines(Index coordinate, const Eigen::MatrixXd& bases, int count) const {
  const Eigen::VectorXd nodes = nodes_of(coordinate, count);
  Eigen::MatrixXd points(bases.rows(), bases.cols() * count);
  for (Index line = 0; line < bases.cols(); ++line) {
    points.middleCols(line * count, count) = bases.col(line).replicate(1, count);
    points.block(coordinate, line * count, 1, count) = nodes.transpose();
  }
  return points;
}

Eigen::VectorXd LineNodes::tail_along(Index coordinate, const Eigen::MatrixXd& bases, int count) const {
  const Eigen::MatrixXd transform = chebyshev_transform(count);
  Eigen::VectorXd tail = Eigen::VectorXd::Zero(count);
  for (Index first = 0; first < bases.cols(); first += kTogether) {
    const Eigen::MatrixXd values = values_(lines(coordinate, bases.middleCols(first, kTogether), count));
    for (Index line = 0; line < kTogether; ++line)
      tail = tail.cwiseMax(tail_of(values.middleCols(line * count, count), transform));
  }
  return tail;
}

/// Sums of coefficients bound errors from above. Here the error itself is looked at, between the nodes.
std::optional<Front> LineNodes::front_along(Index coordinate, const Eigen::MatrixXd& bases,
                                            double tolerance) const {
  const int count = 2 * max_nodes_ - 1;  // every other one is a node of the coarse axis
  const Eigen::MatrixXd between =
      pgd::interpolation_matrix(axis_of_(coordinate, max_nodes_), nodes_of(coordinate, count));
  Front worst;
  worst.allowed = max_nodes_;
  Eigen::VectorXd base;
  for (Index first = 0; first < bases.cols(); first += kTogether) {
    const Eigen::MatrixXd values = values_(lines(coordinate, bases.middleCols(first, kTogether), count));
    for (Index line = 0; line < kTogether; ++line) {
      const auto exact = values.middleCols(line * count, count);
      const Eigen::MatrixXd at_nodes = exact(Eigen::all, Eigen::seqN(0, max_nodes_, 2));
      Index row = 0, place = 0;
      const double error = (at_nodes * between.transpose() - exact).cwiseAbs().maxCoeff(&row, &place);
      if (!(error > worst.error)) continue;
      worst.error = error;
      worst.row = row;
      base = bases.col(first + line);
    }
  }
  if (!(worst.error > tolerance)) return {};
  worst.coordinate = coordinate;
  for (int more = count; more <= kMostFront && worst.nodes == 0; more = 2 * more - 1) {
    const Eigen::MatrixXd points = lines(coordinate, base, more);
    const Eigen::MatrixXd values = values_(points);
    const Eigen::RowVectorXd x = points.row(coordinate), value = values.row(worst.row);
    const Eigen::RowVectorXd slopes = ((value.tail(more - 1) - value.head(more - 1)).array() /
                                       (x.tail(more - 1) - x.head(more - 1)).array())
                                          .abs();
    Index steepest = 0;
    worst.width = (value.maxCoeff() - value.minCoeff()) / slopes.maxCoeff(&steepest);
    worst.point = points.col(steepest);
    const int nodes = nodes_for(tail_of(value, chebyshev_transform(more)), tolerance);
    if (nodes < more - 1) worst.nodes = nodes;
  }
  return worst;
}

}  // namespace samara::codebooks
