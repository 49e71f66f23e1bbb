#include "samara/pgd/sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/growing_cross.h"
#include "samara/pgd/lagrange.h"
#include "samara/pgd/leja.h"
#include "samara/pgd/random.h"
#include "samara/pgd/sample_table.h"
#include "samara/pgd/transform_trial.h"

namespace samara::pgd {

namespace {

constexpr int kFirstNodes = 3;
constexpr int kGuardPivots = 2;
constexpr int kCandidates = 4000;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void validate(const std::vector<SampledCoordinate>& coordinates, const std::vector<OutputLabel>& outputs,
              const SamplingOptions& o) {
  if (coordinates.empty() || outputs.empty()) {
    throw ArgumentError(
        fmt::format("sampling of {} coordinates and {} outputs, expected at least one of each",
                    coordinates.size(), outputs.size()));
  }
  std::set<std::string> names;
  for (const SampledCoordinate& c : coordinates) {
    if (!(std::isfinite(c.lower) && std::isfinite(c.upper) && c.lower < c.upper)) {
      throw ArgumentError(
          fmt::format("{} goes from {} to {}, expected an interval", c.label.name, c.lower, c.upper));
    }
    if (!in_domain(c.label.transform, c.lower) || !in_domain(c.label.transform, c.upper)) {
      throw ArgumentError(fmt::format("{} goes from {} to {}, which the transform {} does not allow",
                                      c.label.name, c.lower, c.upper, to_string(c.label.transform)));
    }
    if (!names.insert(c.label.name).second) {
      throw ArgumentError(fmt::format("two coordinates are named \"{}\"", c.label.name));
    }
  }
  const auto require = [](bool holds, const char* field, double value, const char* expected) {
    if (!holds)
      throw ArgumentError(fmt::format("SamplingOptions::{} is {}, expected {}", field, value, expected));
  };
  require(o.tolerance > 0.0 && o.tolerance < 1.0, "tolerance", o.tolerance, "between 0 and 1");
  require(o.max_calls >= 1, "max_calls", static_cast<double>(o.max_calls), "at least 1");
  require(o.max_seconds >= 0.0, "max_seconds", o.max_seconds, "at least 0");
  require(o.max_rank >= 1, "max_rank", o.max_rank, "at least 1");
  require(o.max_nodes >= kFirstNodes && o.max_nodes <= kMostLejaPoints, "max_nodes", o.max_nodes, "3 to 128");
  require(o.guard_points >= 1, "guard_points", o.guard_points, "at least 1");
  require(o.check_points >= 1, "check_points", o.check_points, "at least 1");
  const auto rows = static_cast<Eigen::Index>(coordinates.size());
  if (o.start.size() > 0 && (o.start.rows() != rows || !o.start.allFinite())) {
    throw ArgumentError(fmt::format("SamplingOptions::start has {} coordinates, expected {} finite ones",
                                    o.start.rows(), rows));
  }
  const auto count = static_cast<Eigen::Index>(outputs.size());
  if (o.absolute.size() > 0 && (o.absolute.size() != count || !(o.absolute.array() >= 0.0).all())) {
    throw ArgumentError(fmt::format("SamplingOptions::absolute has {} entries, expected {} of at least 0",
                                    o.absolute.size(), count));
  }
}

/// The train on Leja nodes as a field on Chebyshev axes of the same degree.
TrainField on_chebyshev_axes(const std::vector<SampledCoordinate>& coordinates,
                             const std::vector<CoordinateMap>& maps, const std::vector<OutputLabel>& outputs,
                             TensorTrain train) {
  std::vector<Axis> axes;
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    const SampledCoordinate& c = coordinates[k];
    TrainCore& core = train.cores[k + 1];
    Axis::Label label = c.label;
    label.transform = maps[k].transform();
    axes.push_back(Axis::chebyshev(label, c.lower, c.upper, core.size));
    const LagrangeBasis basis(leja_points(core.size));
    TrainCore moved(core.left, core.size, core.right);
    Eigen::VectorXd weights(core.size);
    for (int i = 0; i < core.size; ++i) {
      // The ends are nodes of both.
      const double u = std::clamp(maps[k].to_unit(axes[k].nodes()[i]), -1.0, 1.0);
      basis.values(u, weights);
      for (int r = 0; r < core.right; ++r) {
        for (int j = 0; j < core.size; ++j) {
          moved.data.segment(Eigen::Index{core.left} * (i + Eigen::Index{core.size} * r), core.left) +=
              weights[j] *
              core.data.segment(Eigen::Index{core.left} * (j + Eigen::Index{core.size} * r), core.left);
        }
      }
    }
    core = std::move(moved);
  }
  return {std::move(axes), outputs, std::move(train)};
}

/// Errors at points, over the scales of the outputs.
struct PointErrors {
  Eigen::VectorXd largest;  ///< per point, over the outputs
  double root_mean_square = 0.0;

  double worst() const { return largest.maxCoeff(); }
};

class Sampling {
 public:
  Sampling(const std::vector<SampledCoordinate>& coordinates, const std::vector<OutputLabel>& outputs,
           const PointsFunction& function, const SamplingOptions& options)
      : coordinates_(coordinates),
        outputs_(outputs),
        options_(options),
        function_(coordinates, outputs, function, options),
        random_(options.seed),
        tolerance_(kShare * options.tolerance) {
    result_.error = result_.root_mean_square_error = kInfinity;
  }

  SamplingResult run() {
    try {
      start();
      while (!round()) continue;
    } catch (const SamplingStopped& stopped) {
      result_.status = stopped.status;
      result_.message = stopped.message;
      result_.bad_point = stopped.bad_point;
    }
    finish();
    return std::move(result_);
  }

 private:
  void start() {
    std::vector<CoordinateMap> maps;
    const std::vector<Transform> transforms = try_transforms(coordinates_, function_, random_.bits());
    for (std::size_t k = 0; k < coordinates_.size(); ++k) {
      maps.emplace_back(coordinates_[k].lower, coordinates_[k].upper, transforms[k]);
    }
    table_.emplace(function_, std::move(maps));
    cross_.emplace(*table_, std::vector<int>(coordinates_.size(), kFirstNodes), options_.max_rank,
                   random_.bits());
    for (Eigen::Index j = 0; j < options_.start.cols(); ++j) {
      cross_->add_pivot(nearest_node(options_.start.col(j)), tolerance_);
    }
  }

  /// @returns true if the work is done, with status and message set
  bool round() {
    cross_->grow(tolerance_);
    const std::optional<TrainField> before = std::move(latest_);
    latest_ = on_chebyshev_axes(coordinates_, table_->maps(), outputs_, cross_->train());
    before_ = before ? &*before : nullptr;
    const TrainField& field = *latest_;
    const Eigen::MatrixXd guard = suspicious_points(options_.guard_points);
    errors_at(field, guard);
    // All points off the grid that were ever called count, not the fresh ones only.
    const PointErrors errors = differences(field, seen_points_, seen_values_);
    keep_if_best(field, errors);
    const std::vector<int> rough = rough_coordinates(field);
    if (errors.worst() <= options_.tolerance && rough.empty() && check(field)) return true;
    const int pivots = add_worst(seen_points_, errors) + new_pivots_;
    const bool finer = refine(rough);
    if (pivots == 0 && !finer) {
      if (cross_->ranks_are_exhausted() || nodes_are_exhausted()) {
        return stop(SamplingStatus::exhausted, "ranks and nodes allowed are used up");
      }
      be_stricter();
    }
    return stagnated();
  }

  Eigen::MatrixXd random_points(int count) {
    Eigen::MatrixXd points(function_.coordinates(), count);
    for (Eigen::Index j = 0; j < count; ++j) {
      for (Eigen::Index k = 0; k < points.rows(); ++k) {
        const SampledCoordinate& c = coordinates_[static_cast<std::size_t>(k)];
        points(k, j) = c.lower + (c.upper - c.lower) * random_.uniform();
      }
    }
    return points;
  }

  /// Half of them uniform in the box. The other half are those of many candidates at which the interpolant
  /// and the one of the round before differ most: uniform ones, and ones that share some coordinates with a
  /// pivot and are near it in others. So narrow features are looked at where they are, not where they are
  /// not.
  Eigen::MatrixXd suspicious_points(int count) {
    Eigen::MatrixXd points = random_points(count);
    if (before_ == nullptr) return points;
    const Eigen::MatrixXd pivots = cross_->pivots();
    const int wanted = count / 2;
    Eigen::MatrixXd candidates = random_points(kCandidates);
    for (Eigen::Index j = 0; j < kCandidates / 2; ++j) {
      const Eigen::VectorXd pivot = pivots.col(random_.below(static_cast<int>(pivots.cols())));
      for (Eigen::Index k = 0; k < pivot.size(); ++k) {
        const SampledCoordinate& c = coordinates_[static_cast<std::size_t>(k)];
        const double way = 0.1 * (c.upper - c.lower) * random_.normal();
        if (random_.uniform() < 0.25) continue;
        candidates(k, j) = std::clamp(pivot[k] + way, c.lower, c.upper);
      }
    }
    const Eigen::VectorXd doubt = disagreement(candidates);
    const std::vector<Eigen::Index> order = descending(doubt);
    for (int j = 0; j < wanted; ++j) points.col(j) = candidates.col(order[static_cast<std::size_t>(j)]);
    return points;
  }

  /// Differences of the latest two interpolants, over the scales, largest output.
  Eigen::VectorXd disagreement(const Eigen::MatrixXd& points) const {
    const Eigen::VectorXd per_scale = function_.scale().cwiseInverse();
    TrainField::Workspace workspace = latest_->make_workspace();
    TrainField::Workspace workspace_before = before_->make_workspace();
    Eigen::VectorXd values(latest_->output_count());
    Eigen::VectorXd values_before(latest_->output_count());
    Eigen::VectorXd difference(points.cols());
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      const std::span<const double> x(points.col(j).data(), static_cast<std::size_t>(points.rows()));
      latest_->evaluate(x, values, workspace);
      before_->evaluate(x, values_before, workspace_before);
      difference[j] = (values - values_before).cwiseProduct(per_scale).cwiseAbs().maxCoeff();
    }
    return difference;
  }

  static std::vector<Eigen::Index> descending(const Eigen::VectorXd& values) {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::ranges::sort(order, [&](Eigen::Index a, Eigen::Index b) { return values[a] > values[b]; });
    return order;
  }

  /// Calls the function at points off the grid, remembers them, and compares.
  PointErrors errors_at(const TrainField& field, const Eigen::MatrixXd& points) {
    const Eigen::MatrixXd exact = function_(points);
    const Eigen::Index known = seen_points_.cols();
    seen_points_.conservativeResize(points.rows(), known + points.cols());
    seen_points_.rightCols(points.cols()) = points;
    seen_values_.conservativeResize(exact.rows(), known + points.cols());
    seen_values_.rightCols(points.cols()) = exact;
    return differences(field, points, exact);
  }

  PointErrors differences(const TrainField& field, const Eigen::MatrixXd& points,
                          const Eigen::MatrixXd& exact) const {
    const Eigen::VectorXd per_scale = function_.scale().cwiseInverse();
    TrainField::Workspace workspace = field.make_workspace();
    Eigen::VectorXd values(field.output_count());
    PointErrors errors;
    errors.largest.resize(points.cols());
    double sum = 0.0;
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      field.evaluate({points.col(j).data(), static_cast<std::size_t>(points.rows())}, values, workspace);
      const Eigen::VectorXd error = (values - exact.col(j)).cwiseProduct(per_scale).cwiseAbs();
      errors.largest[j] = error.maxCoeff();
      sum += error.squaredNorm();
    }
    errors.root_mean_square = std::sqrt(sum / static_cast<double>(exact.size()));
    return errors;
  }

  void keep_if_best(const TrainField& field, const PointErrors& errors) {
    result_.history.push_back({function_.calls(), errors.worst(), cross_->ranks(), cross_->nodes()});
    function_.report(std::clamp(std::log(errors.worst()) / std::log(options_.tolerance), 0.0, 1.0));
    if (result_.field && !(errors.worst() < result_.error)) return;
    result_.field = field;
    result_.error = errors.worst();
    result_.root_mean_square_error = errors.root_mean_square;
    result_.points_checked = static_cast<int>(seen_points_.cols());
    calls_of_best_ = function_.calls();
  }

  /// Whether fresh points agree; those that do not become pivots.
  bool check(const TrainField& field) {
    const Eigen::MatrixXd points = suspicious_points(options_.check_points);
    const PointErrors errors = errors_at(field, points);
    result_.field = field;
    result_.error = errors.worst();
    result_.root_mean_square_error = errors.root_mean_square;
    result_.points_checked = options_.check_points;
    if (errors.worst() <= options_.tolerance) {
      return stop(SamplingStatus::met,
                  fmt::format("largest error {:.3g} <= {:.3g} at {} points of the check", errors.worst(),
                              options_.tolerance, options_.check_points));
    }
    new_pivots_ = add_worst(points, errors);
    return false;
  }

  int add_worst(const Eigen::MatrixXd& points, const PointErrors& errors) {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(points.cols()));
    for (std::size_t j = 0; j < order.size(); ++j) order[j] = static_cast<Eigen::Index>(j);
    std::ranges::sort(order,
                      [&](Eigen::Index a, Eigen::Index b) { return errors.largest[a] > errors.largest[b]; });
    int added = 0;
    for (std::size_t j = 0; j < order.size() && j < kGuardPivots; ++j) {
      if (!(errors.largest[order[j]] > tolerance_)) break;
      added += cross_->add_pivot(nearest_node(points.col(order[j])), tolerance_);
    }
    return added;
  }

  Eigen::VectorXi nearest_node(const Eigen::VectorXd& x) const {
    Eigen::VectorXi node(x.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      const double u =
          table_->maps()[i].to_unit(std::clamp(x[k], coordinates_[i].lower, coordinates_[i].upper));
      (leja_points(cross_->nodes()[i]).array() - u).abs().minCoeff(&node[k]);
    }
    return node;
  }

  /// Coordinates along which the last coefficients of the interpolant are not small yet.
  std::vector<int> rough_coordinates(const TrainField& field);
  bool refine(const std::vector<int>& rough) {
    bool finer = false;
    for (const int k : rough) {
      const auto i = static_cast<std::size_t>(k);
      const int step = tails_[i] < 10.0 * tolerance_ ? 1 : 2;
      const int count = std::min(cross_->nodes()[i] + step, options_.max_nodes);
      finer = finer || count > cross_->nodes()[i];
      cross_->set_nodes(k, count);
    }
    return finer;
  }

  bool nodes_are_exhausted() const {
    return std::ranges::all_of(cross_->nodes(), [&](int n) { return n >= options_.max_nodes; });
  }

  /// The guard sees errors, but neither search nor decay does: a stricter search, and in turn finer grids.
  void be_stricter() {
    new_pivots_ = 0;
    std::vector<int> all;
    for (int k = 0; k < function_.coordinates(); ++k) all.push_back(k);
    refine(all);
    if (tolerance_ > 0.01 * options_.tolerance) tolerance_ *= 0.5;
  }

  bool stagnated() {
    constexpr int kRounds = 12;
    constexpr double kManyMore = 3.0;
    new_pivots_ = 0;
    const auto rounds = result_.history.size();
    if (rounds < 2 * kRounds ||
        static_cast<double>(function_.calls()) < kManyMore * static_cast<double>(calls_of_best_))
      return false;
    return stop(SamplingStatus::stagnated,
                fmt::format("three times as many calls did not lower the error of {:.3g}", result_.error));
  }

  bool stop(SamplingStatus status, std::string message) {
    result_.status = status;
    result_.message = std::move(message);
    return true;
  }

  void finish() {
    result_.calls = function_.calls();
    result_.seconds = function_.seconds();
    result_.range = function_.range();
    if (cross_) {
      result_.grid_size = 1.0;
      for (const int n : cross_->nodes()) result_.grid_size *= n;
      result_.pivots = cross_->pivots();
    }
    if (result_.status == SamplingStatus::met) {
      result_.message += fmt::format(", with {} calls", result_.calls);
    } else if (result_.field) {
      result_.message +=
          fmt::format("; the best after {} calls errs by {:.3g} > {:.3g} at {} points of the guard",
                      result_.calls, result_.error, options_.tolerance, result_.points_checked);
    }
  }

  /// The search works to this share of the tolerance, the rest is for what it does not see.
  static constexpr double kShare = 0.5;

  const std::vector<SampledCoordinate>& coordinates_;
  const std::vector<OutputLabel>& outputs_;
  const SamplingOptions& options_;
  SampledFunction function_;
  Random random_;
  double tolerance_;
  std::optional<SampleTable> table_;
  std::optional<GrowingCross> cross_;
  std::optional<TrainField> latest_;
  const TrainField* before_ = nullptr;         ///< the interpolant of the round before, during a round
  Eigen::MatrixXd seen_points_, seen_values_;  ///< off the grid
  std::vector<double> tails_;                  ///< per coordinate, see rough_coordinates()
  int new_pivots_ = 0;
  long calls_of_best_ = 0;
  SamplingResult result_;
};

/// Coefficients of Chebyshev's polynomials T_0 .. T_n-1 along mode k instead of values at Chebyshev nodes.
Eigen::MatrixXd last_coefficient_rows(int size) {
  // Values at the Lobatto points to coefficients, (2/n) cos sums with halved ends; only the last two rows.
  const int n = size - 1;
  const int rows = std::min(2, size);
  Eigen::MatrixXd weights(rows, size);
  for (int r = 0; r < rows; ++r) {
    const int j = size - rows + r;
    for (int i = 0; i < size; ++i) {
      const double half_i = (i == 0 || i == n) ? 0.5 : 1.0;
      const double half_j = (j == 0 || j == n) ? 0.5 : 1.0;
      // Nodes ascend: node i is cos(pi (n - i) / n).
      weights(r, i) = 2.0 / n * half_i * half_j * std::cos(std::numbers::pi * j * (n - i) / n);
    }
  }
  return weights;
}

std::vector<int> Sampling::rough_coordinates(const TrainField& field) {
  constexpr int kLines = 30;
  constexpr double kSmall = 0.25;
  const Eigen::MatrixXd pivots = cross_->pivots();
  const Eigen::VectorXd per_scale = function_.scale().cwiseInverse();
  const int d = field.axis_count();
  TrainField::Workspace workspace = field.make_workspace();
  Eigen::VectorXd values(field.output_count());
  std::vector<double> sums(static_cast<std::size_t>(d), 0.0);
  for (int line = 0; line < kLines; ++line) {
    // Through random points and, where narrow features are, through pivots.
    Eigen::VectorXd x = random_points(1).col(0);
    if (line % 2 == 1) x = pivots.col(random_.below(static_cast<int>(pivots.cols())));
    for (int k = 0; k < d; ++k) {
      const Axis& axis = field.axes()[static_cast<std::size_t>(k)];
      const double kept = x[k];
      const Eigen::MatrixXd rows = last_coefficient_rows(axis.size());
      Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(field.output_count(), rows.rows());
      for (int i = 0; i < axis.size(); ++i) {
        x[k] = axis.nodes()[i];
        field.evaluate({x.data(), static_cast<std::size_t>(d)}, values, workspace);
        coefficients += values * rows.col(i).transpose();
      }
      x[k] = kept;
      sums[static_cast<std::size_t>(k)] +=
          (per_scale.asDiagonal() * coefficients).rowwise().squaredNorm().maxCoeff();
    }
  }
  tails_.clear();
  std::vector<int> rough;
  for (int k = 0; k < d; ++k) {
    tails_.push_back(std::sqrt(sums[static_cast<std::size_t>(k)] / kLines));
    if (tails_.back() > kSmall * options_.tolerance) rough.push_back(k);
  }
  return rough;
}

}  // namespace

SamplingResult sample(const std::vector<SampledCoordinate>& coordinates,
                      const std::vector<OutputLabel>& outputs, const PointsFunction& function,
                      const SamplingOptions& options) {
  validate(coordinates, outputs, options);
  return Sampling(coordinates, outputs, function, options).run();
}

std::string to_string(SamplingStatus status) {
  switch (status) {
    case SamplingStatus::met:
      return "met";
    case SamplingStatus::max_calls:
      return "max_calls";
    case SamplingStatus::max_seconds:
      return "max_seconds";
    case SamplingStatus::exhausted:
      return "exhausted";
    case SamplingStatus::stagnated:
      return "stagnated";
    case SamplingStatus::not_finite:
      return "not_finite";
    case SamplingStatus::failed:
      return "failed";
    case SamplingStatus::cancelled:
      return "cancelled";
  }
  return "unknown";
}

}  // namespace samara::pgd
