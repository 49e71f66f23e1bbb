#include "samara/pgd/evolution/slab_join.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/fields/field_rounding.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

// The tolerance is shared: what joining leaves out on the way, elements of time, nodes of the parameters,
// ranks.
constexpr double kJoinShare = 0.05, kTimeShare = 0.15, kNodeShare = 0.4, kRankShare = 0.7;

// One field may take this many times the numbers of two: questions that meet both pay for each by itself.
constexpr double kWorthOfOne = 1.5;

bool is_one_element(const Axis& axis) {
  return axis.basis() == Basis::chebyshev && axis.elements() == 1;
}

/// The axis that holds the functions of both, if there is one.
std::optional<Axis> common_axis(const Axis& a, const Axis& b) {
  const bool same_interval = a.basis() == b.basis() && a.transform() == b.transform() &&
                             a.lower() == b.lower() && a.upper() == b.upper();
  if (same_interval && a.size() == b.size() && a.nodes() == b.nodes()) return a;
  if (same_interval && is_one_element(a) && is_one_element(b)) return a.size() > b.size() ? a : b;
  return std::nullopt;
}

Axis time_with_borders(const Axis& like, const Eigen::VectorXd& borders) {
  const Axis::Label label{like.name(), like.unit(), like.role(), like.transform()};
  return Axis::of_elements(label, like.basis(), borders, like.degree());
}

/// Axes of both fields as one, time first; none if they do not fit together.
std::optional<std::vector<Axis>> common_axes(const TrainField& earlier, const TrainField& later) {
  const Axis& a = earlier.axes().front();
  const Axis& b = later.axes().front();
  if (!a.has_elements() || a.basis() != b.basis() || a.degree() != b.degree() ||
      a.transform() != b.transform() || a.upper() != b.lower())
    return std::nullopt;
  Eigen::VectorXd borders(a.borders().size() + b.borders().size() - 1);
  borders << a.borders(), b.borders().tail(b.borders().size() - 1);
  std::vector<Axis> axes = {time_with_borders(a, borders)};
  for (std::size_t k = 1; k < earlier.axes().size(); ++k) {
    const std::optional<Axis> axis = common_axis(earlier.axes()[k], later.axes()[k]);
    if (!axis) return std::nullopt;
    axes.push_back(*axis);
  }
  return axes;
}

/// Ranks cut by the mean square over all nodes.
TensorTrain rounded_by_mean(TensorTrain train, const Eigen::VectorXd& scale, double tolerance) {
  train.cores[0].left_unfolding() = scale.cwiseInverse().asDiagonal() * train.cores[0].left_unfolding();
  const double entries = full_size(train);
  train = rounded(std::move(train), tolerance * std::sqrt(entries));
  train.cores[0].left_unfolding() = scale.asDiagonal() * train.cores[0].left_unfolding();
  return train;
}

std::optional<TrainField> joined(const TrainField& earlier, const TrainField& later,
                                 const Eigen::VectorXd& scale, double tolerance) {
  std::optional<std::vector<Axis>> axes = common_axes(earlier, later);
  if (!axes) return std::nullopt;
  // Both over all times, each zero at those of the other; the time where they meet is the earlier one's.
  const auto placed = [&](const TrainField& field, Eigen::Index first, Eigen::Index left_out) {
    std::vector<Axis> to = *axes;
    to.front() = field.axes().front();
    const Eigen::Index count = to.front().size() - left_out;
    Eigen::MatrixXd place = Eigen::MatrixXd::Zero(axes->front().size(), to.front().size());
    place.block(first, left_out, count, count).setIdentity();
    return applied(carried_over(field.train(), field.axes(), to), 1, place);
  };
  TensorTrain both = sum(placed(earlier, 0, 0), placed(later, earlier.axes().front().size(), 1));
  return TrainField(std::move(*axes), earlier.outputs(), rounded_by_mean(std::move(both), scale, tolerance));
}

/// Halves are joined first, so that trains stay short. Fields are joined where that takes not many more
/// numbers.
std::vector<TrainField> join_all(std::vector<TrainField> fields, const Eigen::VectorXd& scale,
                                 double tolerance) {
  if (fields.size() < 2) return fields;
  const auto middle = fields.begin() + static_cast<std::ptrdiff_t>(fields.size() / 2);
  std::vector<TrainField> front = join_all({fields.begin(), middle}, scale, tolerance);
  std::vector<TrainField> back = join_all({middle, fields.end()}, scale, tolerance);
  std::optional<TrainField> one = joined(front.back(), back.front(), scale, tolerance);
  if (one && static_cast<double>(one->entries()) <=
                 kWorthOfOne * static_cast<double>(front.back().entries() + back.front().entries())) {
    front.back() = std::move(*one);
    back.erase(back.begin());
  }
  for (TrainField& field : back) front.push_back(std::move(field));
  return front;
}

/// Trial points of the axes other than one: corners and random points.
Eigen::MatrixXd trial_points(const std::vector<Axis>& axes, Random& random) {
  constexpr int kPoints = 256;
  Eigen::MatrixXd points(static_cast<Eigen::Index>(axes.size()), kPoints);
  for (Eigen::Index j = 0; j < kPoints; ++j) {
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const Axis& axis = axes[k];
      double x = axis.lower() + axis.length() * random.uniform();
      if (j % 2 == 1 && k > 0) x = random.below(2) == 1 ? axis.upper() : axis.lower();
      if (axis.is_list()) x = axis.nodes()[random.below(axis.size())];
      points(static_cast<Eigen::Index>(k), j) = x;
    }
  }
  return points;
}

/// Values along an axis, through trial points of the others: nodes x (points, outputs), over scales.
Eigen::MatrixXd lines(const TrainField& field, std::size_t axis, const Eigen::MatrixXd& points,
                      const Eigen::VectorXd& scale) {
  const std::vector<TrainCore>& cores = field.train().cores;
  const TrainCore& along = cores[axis + 1];
  const auto outputs = static_cast<Eigen::Index>(field.output_count());
  Eigen::MatrixXd lines(along.size, points.cols() * outputs);
  const auto slice = [&](std::size_t k, double x) {
    InterpolationStencil stencil = field.axes()[k].make_stencil();
    Eigen::MatrixXd matrix(cores[k + 1].left, cores[k + 1].right);
    field.slice(static_cast<int>(k), x, stencil, matrix);
    return matrix;
  };
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    Eigen::MatrixXd before = scale.cwiseInverse().asDiagonal() * cores[0].left_unfolding();
    for (std::size_t k = 0; k < axis; ++k) before *= slice(k, points(static_cast<Eigen::Index>(k), j));
    Eigen::VectorXd after = Eigen::VectorXd::Ones(1);
    for (std::size_t k = field.axes().size(); k-- > axis + 1;)
      after = slice(k, points(static_cast<Eigen::Index>(k), j)) * after;
    for (int i = 0; i < along.size; ++i)
      lines.block(i, j * outputs, 1, outputs) = (before * (along.slice(i) * after)).transpose();
  }
  return lines;
}

/// Nodes and the middles between them.
Eigen::VectorXd check_points(const Axis& axis) {
  const Eigen::VectorXd& nodes = axis.nodes();
  Eigen::VectorXd points(2 * nodes.size() - 1);
  for (Eigen::Index i = 0; i < nodes.size(); ++i) {
    points[2 * i] = nodes[i];
    if (i + 1 < nodes.size()) points[2 * i + 1] = 0.5 * (nodes[i] + nodes[i + 1]);
  }
  return points;
}

/// Largest change of lines when they are interpolated on another axis.
double change(const Eigen::MatrixXd& lines, const Axis& from, const Axis& to, const Eigen::VectorXd& points) {
  const Eigen::MatrixXd there = interpolation_matrix(from, to.nodes()) * lines;
  return (interpolation_matrix(to, points) * there - interpolation_matrix(from, points) * lines)
      .cwiseAbs()
      .maxCoeff();
}

/// As few elements of time as the lines allow, each as long as possible.
Axis with_fewer_elements(const Axis& time, const Eigen::MatrixXd& lines, double tolerance) {
  const Eigen::VectorXd& borders = time.borders();
  const Eigen::VectorXd all = check_points(time);
  std::vector<double> kept = {borders[0]};
  for (Eigen::Index e = 0; e + 1 < borders.size();) {
    Eigen::Index end = e + 1;
    for (; end + 1 < borders.size(); ++end) {
      const Axis trial = time_with_borders(time, Eigen::Vector2d(borders[e], borders[end + 1]));
      const double* const stop = all.data() + all.size();
      const double* const first = std::lower_bound(all.data(), stop, borders[e]);
      const double* const last = std::upper_bound(first, stop, borders[end + 1]);
      if (change(lines, time, trial, Eigen::Map<const Eigen::VectorXd>(first, last - first)) > tolerance)
        break;
    }
    kept.push_back(borders[end]);
    e = end;
  }
  if (static_cast<Eigen::Index>(kept.size()) == borders.size()) return time;
  return time_with_borders(
      time, Eigen::Map<const Eigen::VectorXd>(kept.data(), static_cast<Eigen::Index>(kept.size())));
}

Axis with_fewer_nodes(const Axis& axis, const Eigen::MatrixXd& lines, double tolerance) {
  if (!is_one_element(axis)) return axis;
  const Axis::Label label{axis.name(), axis.unit(), axis.role(), axis.transform()};
  const Eigen::VectorXd points = check_points(axis);
  for (int count = 2; count < axis.size(); ++count) {
    Axis trial = Axis::chebyshev(label, axis.lower(), axis.upper(), count);
    if (change(lines, axis, trial, points) <= tolerance) return trial;
  }
  return axis;
}

TrainField with_lean_axes(const TrainField& field, const Eigen::VectorXd& scale,
                          const CompactOptions& options, Random& random) {
  const double tolerance = options.tolerance;
  const Eigen::MatrixXd points = trial_points(field.axes(), random);
  const auto parameters = static_cast<double>(std::max<std::size_t>(1, field.axes().size() - 1));
  std::vector<Axis> axes = field.axes();
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const std::vector<std::string>& kept = options.kept_axes;
    if (k > 0 && std::find(kept.begin(), kept.end(), axes[k].name()) != kept.end()) continue;
    const Eigen::MatrixXd values = lines(field, k, points, scale);
    axes[k] = k == 0 ? with_fewer_elements(axes[k], values, kTimeShare * tolerance)
                     : with_fewer_nodes(axes[k], values, kNodeShare * tolerance / parameters);
  }
  TensorTrain train = carried_over(field.train(), field.axes(), axes);
  return TrainField(std::move(axes), field.outputs(), std::move(train));
}

}  // namespace

std::vector<TrainField> compacted(const std::vector<TrainField>& fields, const Eigen::VectorXd& scale,
                                  const CompactOptions& options) {
  for (const TrainField& field : fields) {
    if (scale.size() != field.output_count() || !(scale.minCoeff() > 0.0) || !scale.allFinite()) {
      throw ArgumentError(
          fmt::format("fields of {} outputs made compact by {} scales, expected as many positive ones",
                      field.output_count(), scale.size()));
    }
  }
  if (!(options.tolerance > 0.0 && options.tolerance < 1.0)) {
    throw ArgumentError(
        fmt::format("fields made compact to {}, expected a tolerance between 0 and 1", options.tolerance));
  }
  Random random(options.seed);
  std::vector<TrainField> result;
  for (const TrainField& field : join_all(fields, scale, kJoinShare * options.tolerance)) {
    const TrainField lean = with_lean_axes(field, scale, options, random);
    result.push_back(rounded(lean, scale, kRankShare * options.tolerance, options.seed).field);
  }
  return result;
}

}  // namespace samara::pgd
