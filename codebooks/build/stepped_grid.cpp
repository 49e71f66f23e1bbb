#include "samara/codebooks/build/stepped_grid.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>

#include <fmt/format.h>

#include "samara/base/termination.h"
#include "samara/codebooks/build/front_finder.h"

namespace samara::codebooks {

namespace {

using Eigen::Index;

constexpr int kLines = 32;
constexpr int kMaxElementNodes = 512;
/// In a box with elements, a coordinate whose polynomial takes more nodes than these is tried in elements, too.
constexpr int kLongBesideElements = 64;
/// Of the interval: elements follow a front narrower than this only where it hardly moves. It is counted from at once.
constexpr double kNarrow = 0.005;

}  // namespace

Eigen::MatrixXd corners_and_inside(const Plan& plan, int count, pgd::Random& random) {
  Eigen::MatrixXd points(static_cast<Index>(plan.box.size()), count);
  for (Index j = 0; j < points.cols(); ++j) {
    for (Index k = 0; k < points.rows(); ++k) {
      const BoxEntry& entry = plan.box[static_cast<std::size_t>(k)];
      const double share = 2 * j < points.cols() ? random.below(2) : random.uniform();
      points(k, j) = entry.lower + (entry.upper - entry.lower) * share;
    }
  }
  return points;
}

SteppedGrid::SteppedGrid(const Plan& plan, const std::vector<pgd::Axis::Label>& coordinates,
                         SteppedTrajectories& trajectories, LineNodes::Values values)
    : plan_(plan),
      labels_(coordinates),
      trajectories_(trajectories),
      values_([this, values = std::move(values)](const Eigen::MatrixXd& points) {
        return values(map_ ? in_box(points) : points);
      }),
      lines_(no_lines()) {}

LineNodes SteppedGrid::no_lines() {
  const auto axis_of = [this](Index k, int nodes) {
    const BoxEntry& entry = plan_.box[static_cast<std::size_t>(k)];
    return pgd::Axis::chebyshev(labels_[static_cast<std::size_t>(k)], entry.lower, entry.upper, nodes);
  };
  return {coordinates(), axis_of, values_,
          std::min(plan_.builder.max_nodes.value_or(LineNodes::kMostNodes), LineNodes::kMostNodes)};
}

void SteppedGrid::look_along_lines(pgd::Random& random) {
  for (Index k = 0; k < coordinates(); ++k) {
    trajectories_.tell("lines", static_cast<double>(k) / static_cast<double>(coordinates()));
    look_along(k, corners_and_inside(plan_, kLines, random));
  }
  if (!are_polynomials_used_up(kFirstShare)) return;
  const LineNodes polynomials = lines_;
  const Front* const front = polynomials.front();
  std::optional<Index> narrow;
  if (front != nullptr && front->width < kNarrow * width_of_box(front->coordinate))
    narrow = front->coordinate;
  if (narrow && count_from(*narrow, random)) return;
  lines_ = polynomials;
  if (cut_into_elements(random) && lines_.front() == nullptr) return;
  for (Index k = 0; k < coordinates(); ++k) {
    if (k != narrow && polynomials.needs_more(k, kFirstShare * plan_.relative) && count_from(k, random))
      return;
  }
  lines_ = polynomials;
}

void SteppedGrid::look_along(Index coordinate, const Eigen::MatrixXd& bases) {
  lines_.look_along(coordinate, bases, 0.1 * kFirstShare * plan_.relative, plan_.relative);
}

/// Those with the most nodes first.  @returns whether elements follow what they were tried at
bool SteppedGrid::cut_into_elements(pgd::Random& random) {
  std::vector<Index> order;
  for (Index k = 0; k < coordinates(); ++k) order.push_back(k);
  const std::vector<int> nodes = nodes_within(kFirstShare);
  std::ranges::stable_sort(order, std::greater<>(),
                           [&](Index k) { return nodes[static_cast<std::size_t>(k)]; });
  for (const Index k : order) {
    if (!cut(k, random)) return false;
  }
  if (!has_elements()) return true;
  for (const Index k : order) {
    if (!lines_.elements(k)) look_along(k, bases_at_fronts(random));
    if (!cut(k, random)) return false;
  }
  return true;
}

/// Has a coordinate in elements, counted from it.  @returns whether these follow all fronts
bool SteppedGrid::count_from(Index counted, pgd::Random& random) {
  trajectories_.tell("front", 0.0);
  FrontFinderOptions options;
  options.lower.resize(coordinates());
  options.upper.resize(coordinates());
  for (Index k = 0; k < coordinates(); ++k) {
    options.lower[k] = plan_.box[static_cast<std::size_t>(k)].lower;
    options.upper[k] = plan_.box[static_cast<std::size_t>(k)].upper;
  }
  options.seed = plan_.builder.seed;
  options.max_points = std::min(options.max_points, trajectories_.left() / 8);
  map_ = find_front(counted, values_, options);
  if (!map_) return false;
  lines_ = no_lines();
  front_places_.resize(coordinates(), 0);
  if (follow_counted(counted, random)) return true;
  map_.reset();
  front_places_.resize(coordinates(), 0);
  return false;
}

bool SteppedGrid::follow_counted(Index counted, pgd::Random& random) {
  std::optional<LineElements> found = find_elements(counted, kFirstShare, random);
  if (!found) return false;
  set_elements(counted, std::move(*found));
  for (Index k = 0; k < coordinates(); ++k) {
    if (k == counted) continue;
    look_along(k, mixed_points(kLines, random));
    look_along(k, points_near_fronts(kLines, random));
  }
  for (Index k = 0; k < coordinates(); ++k) {
    if (!cut(k, random)) return false;
  }
  return lines_.front() == nullptr;
}

Eigen::MatrixXd SteppedGrid::in_box(Eigen::MatrixXd points) const {
  for (Index j = 0; map_ && j < points.cols(); ++j)
    points(map_->coordinate(), j) = map_->from_axis(points.col(j).data());
  return points;
}

/// Where polynomials need many nodes, and elements fewer.  @returns false for a front that elements do not follow
/// either
bool SteppedGrid::cut(Index coordinate, pgd::Random& random) {
  const double bound = kFirstShare * plan_.relative;
  const int nodes = lines_.within(bound)[static_cast<std::size_t>(coordinate)];
  const bool needs_more = lines_.needs_more(coordinate, bound);
  const bool is_long = needs_more || (has_elements() && nodes > kLongBesideElements);
  if (lines_.elements(coordinate) || !is_long) return true;
  tell_of_elements(coordinate);
  std::optional<LineElements> found = find_elements(coordinate, kFirstShare, random);
  if (!found) return !needs_more;
  if (found->axis.size() >= nodes && !needs_more) return true;
  set_elements(coordinate, std::move(*found));
  return true;
}

void SteppedGrid::set_elements(Index coordinate, LineElements found) {
  lines_.set_elements(coordinate, std::move(found.axis));
  const Index known = front_places_.cols();
  front_places_.conservativeResize(coordinates(), known + found.steepest.cols());
  front_places_.rightCols(found.steepest.cols()) = found.steepest;
}

/// Halves of those that the coordinate has.
std::optional<LineElements> SteppedGrid::find_elements(Index coordinate, double share, pgd::Random& random) {
  LineElementsOptions options;
  if (const pgd::Axis* axis = lines_.elements(coordinate)) options.borders = axis->borders();
  // Twice: an error that is seen, not a bound of it.
  options.tolerance = 2.0 * share * plan_.relative;
  options.max_nodes = plan_.builder.max_nodes.value_or(kMaxElementNodes);
  options.max_points = std::min(options.max_points, trajectories_.left() / 8);
  const auto place = static_cast<std::size_t>(coordinate);
  const BoxEntry& entry = plan_.box[place];
  const auto bases = [&] { return bases_at_fronts(random); };
  return elements_along(coordinate, labels_[place], entry.lower, entry.upper, values_, bases, options);
}

/// Of lines, most of them through the places of fronts that are known. About a front that is counted from they are
/// spread: in its middle, where it stands still, values may depend on nothing.
Eigen::MatrixXd SteppedGrid::bases_at_fronts(pgd::Random& random) const {
  if (map_) return mixed_points(kLines, random);
  Eigen::MatrixXd some = corners_and_inside(plan_, kLines, random);
  for (Index j = 0; j < some.cols() && front_places_.cols() > 0; ++j) {
    if (j % 4 != 3) some.col(j) = front_places_.col(random.below(static_cast<int>(front_places_.cols())));
  }
  return some;
}

void SteppedGrid::halve_elements(double share) {
  while (has_elements() && element_share_ > share) {
    element_share_ *= kTighter;
    pgd::Random random(plan_.builder.seed);
    for (Index k = 0; k < coordinates(); ++k) {
      const pgd::Axis* axis = lines_.elements(k);
      if (axis == nullptr) continue;
      tell_of_elements(k);
      std::optional<LineElements> found = find_elements(k, element_share_, random);
      if (!found) {
        throw SteppedEnd({Termination::exhausted,
                          fmt::format("{} elements along {} do not suffice, and halves of them take more "
                                      "nodes than are allowed",
                                      axis->elements(), axis->name())});
      }
      if (found->axis.size() > axis->size()) lines_.set_elements(k, std::move(found->axis));
    }
  }
}

void SteppedGrid::tell_of_elements(Index coordinate) {
  trajectories_.tell("elements", static_cast<double>(coordinate) / static_cast<double>(coordinates()));
}

std::vector<pgd::Axis> SteppedGrid::axes(const std::vector<int>& nodes) const {
  std::vector<pgd::Axis> axes;
  for (Index k = 0; k < coordinates(); ++k)
    axes.push_back(lines_.axis(k, nodes[static_cast<std::size_t>(k)]));
  return axes;
}

bool SteppedGrid::are_same_elements(const std::vector<int>& nodes, const std::vector<int>& others) const {
  for (Index k = 0; k < coordinates(); ++k) {
    const auto place = static_cast<std::size_t>(k);
    if (lines_.elements(k) && nodes[place] != others[place]) return false;
  }
  return true;
}

bool SteppedGrid::are_polynomials_used_up(double share) const {
  for (Index k = 0; k < coordinates(); ++k) {
    if (!lines_.elements(k) && lines_.needs_more(k, share * plan_.relative)) return true;
  }
  return false;
}

Eigen::MatrixXd SteppedGrid::points_near_fronts(int count, pgd::Random& random) const {
  return points_by_elements(axes(nodes_within(1.0)), count, random);
}

Eigen::MatrixXd SteppedGrid::mixed_points(int count, pgd::Random& random) const {
  Eigen::MatrixXd points = corners_and_inside(plan_, count, random);
  if (has_elements())
    points(Eigen::all, Eigen::seqN(0, count / 2, 2)) = points_near_fronts(count / 2, random);
  return points;
}

}  // namespace samara::codebooks
