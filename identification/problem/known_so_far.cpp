#include "samara/identification/problem/known_so_far.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/sobol_points.h"
#include "samara/identification/statistics/cluster_errors.h"
#include "samara/identification/statistics/quantiles.h"

namespace samara::identification {

namespace {

constexpr double kLevel = 0.05;

/// Of a coefficient that the fit gives an error.
bool has_error(const Coefficient& c) {
  return c.determined && !c.at_bound && (c.standard_error || c.naive_standard_error);
}

void check(const FitResult& fitted) {
  if (fitted.status == Termination::failed || fitted.coefficients.empty())
    throw ArgumentError(fmt::format("the fit has no coefficients: {}", fitted.message));
  for (const Coefficient& c : fitted.coefficients) {
    if (!(c.upper > c.lower) || !(c.value >= c.lower && c.value <= c.upper)) {
      throw ArgumentError(fmt::format(
          "the coefficient \"{}\" of the fit is {} in a box from {} to {}; a value in its box was expected",
          c.name, c.value, c.lower, c.upper));
    }
    for (const std::optional<double>& error : {c.standard_error, c.naive_standard_error}) {
      if (!error || (*error > 0.0 && std::isfinite(*error))) continue;
      throw ArgumentError(fmt::format(
          "the standard error of \"{}\" in the fit is {}; a positive number was expected", c.name, *error));
    }
  }
  const auto count = static_cast<Eigen::Index>(fitted.coefficients.size());
  for (const Eigen::MatrixXd* matrix : {&fitted.covariance, &fitted.naive_covariance}) {
    if (matrix->size() == 0 || (matrix->rows() == count && matrix->cols() == count)) continue;
    throw ArgumentError(
        fmt::format("a covariance of the fit is {} x {}; {} x {}, a row for each coefficient, was expected",
                    matrix->rows(), matrix->cols(), count, count));
  }
}

/// Geometric mean of the variances from clusters over the naive ones; 1 where there are none to compare.
double cluster_ratio(const FitResult& fitted) {
  double sum = 0.0;
  int count = 0;
  for (const Coefficient& c : fitted.coefficients) {
    if (!has_error(c) || !c.standard_error || !c.naive_standard_error) continue;
    sum += 2.0 * std::log(*c.standard_error / *c.naive_standard_error);
    ++count;
  }
  return count == 0 ? 1.0 : std::exp(sum / count);
}

/// Whether clusters say more than that frames are independent.
bool is_clustered(const FitResult& fitted, double ratio) {
  if (fitted.clusters < 2 || ratio <= 1.0) return false;
  if (fitted.whiteness && fitted.whiteness->p_value && *fitted.whiteness->p_value < kLevel) return true;
  const int freedom = fitted.clusters - 1;
  return ratio * freedom > chi_squared_quantile(freedom, 1.0 - kLevel);
}

/// With unit diagonal; no correlation where the fit has none to tell.
Eigen::MatrixXd correlation_of(const FitResult& fitted) {
  const auto count = static_cast<Eigen::Index>(fitted.coefficients.size());
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(count, count);
  const bool has_naive = fitted.naive_covariance.size() > 0;
  // Without a naive matrix, as in older files, that of the scatter between clusters may have no inverse.
  if (!has_naive && (fitted.clusters >= 2 || fitted.covariance.size() == 0)) return correlation;
  const Eigen::MatrixXd& covariance = has_naive ? fitted.naive_covariance : fitted.covariance;
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      const double value = covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
      if (i != j && std::isfinite(value)) correlation(i, j) = value;
    }
  }
  const bool is_positive = Eigen::LLT<Eigen::MatrixXd>(correlation).info() == Eigen::Success;
  return is_positive ? correlation : Eigen::MatrixXd::Identity(count, count);
}

/// What is taken for the standard error.
double error_of(const Coefficient& c, bool is_clustered) {
  if (!has_error(c)) return (c.upper - c.lower) / std::sqrt(12.0);
  if (!c.naive_standard_error) return *c.standard_error;
  if (!is_clustered || !c.standard_error) return *c.naive_standard_error;
  return std::max(*c.standard_error, *c.naive_standard_error);
}

/// By how much Student's distribution is wider than a normal one, for an error of clusters.
double student_widening(const FitResult& fitted, const Coefficient& c, bool is_clustered) {
  constexpr double kUpper = 0.975;
  const bool is_of_clusters =
      has_error(c) && c.standard_error && (is_clustered || !c.naive_standard_error) && fitted.clusters >= 2;
  if (!is_of_clusters) return 1.0;
  const double clusters = c.effective_clusters.value_or(fitted.clusters);
  const double freedom = error_degrees(clusters, fitted.clusters);
  return student_quantile(freedom, kUpper) / normal_quantile(kUpper);
}

}  // namespace

KnownSoFar known_so_far(const FitResult& fitted) {
  check(fitted);
  const auto count = static_cast<Eigen::Index>(fitted.coefficients.size());
  KnownSoFar known;
  const double ratio = cluster_ratio(fitted);
  known.is_clustered = is_clustered(fitted, ratio);
  known.inflation = known.is_clustered ? ratio : 1.0;
  known.values.resize(count);
  known.lower.resize(count);
  known.upper.resize(count);
  known.errors.resize(count);
  known.widened.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Coefficient& c = fitted.coefficients[static_cast<std::size_t>(k)];
    known.names.push_back(c.name);
    known.determined.push_back(has_error(c) ? 1 : 0);
    known.values[k] = c.value;
    known.lower[k] = c.lower;
    known.upper[k] = c.upper;
    known.errors[k] = error_of(c, known.is_clustered);
    known.widened[k] = known.errors[k] * student_widening(fitted, c, known.is_clustered);
  }
  known.correlation = correlation_of(fitted);
  for (Eigen::Index k = 0; k < count; ++k) {
    if (known.determined[static_cast<std::size_t>(k)]) continue;
    known.correlation.row(k).setZero();
    known.correlation.col(k).setZero();
    known.correlation(k, k) = 1.0;
  }
  return known;
}

Eigen::MatrixXd KnownSoFar::draws(int count, std::uint64_t seed) const {
  const auto size = static_cast<int>(values.size());
  Eigen::MatrixXd result = values.replicate(1, count);
  if (count == 1) return result;
  const Eigen::MatrixXd unit = codebooks::sobol_points(size, count - 1, seed);
  constexpr double kInside = 1e-12;
  const Eigen::MatrixXd scores =
      unit.unaryExpr([&](double u) { return normal_quantile(std::clamp(u, kInside, 1.0 - kInside)); });
  const Eigen::MatrixXd factor = Eigen::LLT<Eigen::MatrixXd>(correlation).matrixL();
  result.rightCols(count - 1) += errors.asDiagonal() * (factor * scores);
  for (Eigen::Index draw = 1; draw < count; ++draw)
    result.col(draw) = result.col(draw).cwiseMax(lower).cwiseMin(upper);
  return result;
}

}  // namespace samara::identification
