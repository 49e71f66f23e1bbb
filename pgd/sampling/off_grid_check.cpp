#include "samara/pgd/sampling/off_grid_check.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace samara::pgd {

namespace {

constexpr int kCandidates = 4000;

std::vector<Eigen::Index> largest_first(const Eigen::VectorXd& values) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::ranges::sort(order, [&](Eigen::Index a, Eigen::Index b) { return values[a] > values[b]; });
  return order;
}

std::span<const double> column(const Eigen::MatrixXd& points, Eigen::Index j) {
  return {points.col(j).data(), static_cast<std::size_t>(points.rows())};
}

std::string bytes_of(const Eigen::VectorXd& point) {
  return {reinterpret_cast<const char*>(point.data()),
          static_cast<std::size_t>(point.size()) * sizeof(double)};
}

/// Differences of two interpolants over the scales, the largest output.
Eigen::VectorXd disagreement(const TrainField& a, const TrainField& b, const Eigen::MatrixXd& points,
                             const Eigen::VectorXd& scale) {
  TrainField::Workspace workspace_a = a.make_workspace();
  TrainField::Workspace workspace_b = b.make_workspace();
  Eigen::VectorXd values_a(a.output_count());
  Eigen::VectorXd values_b(b.output_count());
  Eigen::VectorXd difference(points.cols());
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    a.evaluate(column(points, j), values_a, workspace_a);
    b.evaluate(column(points, j), values_b, workspace_b);
    difference[j] = (values_a - values_b).cwiseQuotient(scale).cwiseAbs().maxCoeff();
  }
  return difference;
}

void append_columns(Eigen::MatrixXd& matrix, const Eigen::MatrixXd& more) {
  const Eigen::Index known = matrix.cols();
  matrix.conservativeResize(more.rows(), known + more.cols());
  matrix.rightCols(more.cols()) = more;
}

}  // namespace

std::vector<Eigen::Index> PointErrors::descending() const {
  return largest_first(largest);
}

Eigen::MatrixXd OffGridCheck::random_points(int count) {
  Eigen::MatrixXd points(static_cast<Eigen::Index>(coordinates_.size()), count);
  for (Eigen::Index j = 0; j < count; ++j) {
    for (Eigen::Index k = 0; k < points.rows(); ++k) {
      const SampledCoordinate& c = coordinates_[static_cast<std::size_t>(k)];
      points(k, j) = c.lower + (c.upper - c.lower) * random_.uniform();
    }
  }
  return points;
}

/// The first half near pivots in three coordinates of four, the rest uniform.
Eigen::MatrixXd OffGridCheck::candidates(int count, const Eigen::MatrixXd& pivots) {
  constexpr double kNear = 0.1;
  constexpr double kAnywhere = 0.25;
  Eigen::MatrixXd points = random_points(count);
  for (Eigen::Index j = 0; j < count / 2; ++j) {
    const auto pivot = pivots.col(random_.below(static_cast<int>(pivots.cols())));
    for (Eigen::Index k = 0; k < pivot.size(); ++k) {
      const SampledCoordinate& c = coordinates_[static_cast<std::size_t>(k)];
      if (random_.uniform() < kAnywhere) continue;
      const double way = kNear * (c.upper - c.lower) * random_.normal();
      points(k, j) = std::clamp(pivot[k] + way, c.lower, c.upper);
    }
  }
  return points;
}

Eigen::MatrixXd OffGridCheck::suspicious_points(int count, const TrainField& latest, const TrainField& before,
                                                const Eigen::MatrixXd& pivots) {
  const Eigen::MatrixXd pool = candidates(std::max(kCandidates, 2 * count), pivots);
  const std::vector<Eigen::Index> order =
      largest_first(disagreement(latest, before, pool, function_.scale()));
  Eigen::MatrixXd points(pool.rows(), count);
  // Candidates beyond the box were moved to its border: many are the same corner.
  std::set<std::string> taken = called_;
  Eigen::Index j = 0;
  for (const Eigen::Index place : order) {
    if (j == count) break;
    if (taken.insert(bytes_of(pool.col(place))).second) points.col(j++) = pool.col(place);
  }
  return points.leftCols(j);
}

void OffGridCheck::call(const Eigen::MatrixXd& points, Eigen::Index uniform) {
  const Eigen::MatrixXd values = function_.recalled(points);
  for (Eigen::Index j = points.cols() - uniform; j < points.cols(); ++j)
    uniform_.push_back(points_.cols() + j);
  for (Eigen::Index j = 0; j < points.cols(); ++j) called_.insert(bytes_of(points.col(j)));
  append_columns(points_, points);
  append_columns(values_, values);
}

PointErrors OffGridCheck::compare(const TrainField& field, const Eigen::MatrixXd& points,
                                  const Eigen::MatrixXd& reference) const {
  const Eigen::VectorXd scale = function_.scale();
  TrainField::Workspace workspace = field.make_workspace();
  Eigen::VectorXd values(field.output_count());
  PointErrors errors;
  errors.largest.resize(points.cols());
  double sum = 0.0;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    field.evaluate(column(points, j), values, workspace);
    const Eigen::VectorXd error = (values - reference.col(j)).cwiseQuotient(scale).cwiseAbs();
    errors.largest[j] = error.maxCoeff();
    sum += error.squaredNorm();
  }
  errors.root_mean_square = std::sqrt(sum / static_cast<double>(points.cols() * field.output_count()));
  return errors;
}

PointErrors OffGridCheck::errors(const TrainField& field, int count) const {
  return compare(field, points_.rightCols(count), values_.rightCols(count));
}

Eigen::VectorXd OffGridCheck::uniform_errors(const TrainField& field) const {
  return compare(field, uniform_points(), values_(Eigen::all, uniform_)).largest;
}

Eigen::VectorXd OffGridCheck::errors_at(const TrainField& field, const Eigen::MatrixXd& points) {
  return compare(field, points, function_.recalled(points)).largest;
}

}  // namespace samara::pgd
