#include "samara/identification/forecasts/forecast_mixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/forecasts/local_shares.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

void check_shapes(std::span<const Eigen::MatrixXd> said, Eigen::Index rows, Eigen::Index columns) {
  if (said.empty()) throw ArgumentError("no predictor is to be mixed; one or more were expected");
  for (const Eigen::MatrixXd& one : said) {
    if (one.rows() == rows && one.cols() == columns) continue;
    throw ArgumentError(fmt::format("a predictor says {} x {} numbers, where {} x {} were expected",
                                    one.rows(), one.cols(), rows, columns));
  }
}

bool all_speak(std::span<const Eigen::MatrixXd> said, Eigen::Index row) {
  return std::ranges::all_of(said, [&](const Eigen::MatrixXd& one) { return one.row(row).allFinite(); });
}

}  // namespace

Eigen::VectorXd convex_shares(std::span<const Eigen::MatrixXd> said, const Eigen::MatrixXd& measured) {
  check_shapes(said, measured.rows(), measured.cols());
  const auto count = std::ssize(said);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index row = 0; row < measured.rows(); ++row) {
    if (measured.row(row).allFinite() && all_speak(said, row)) rows.push_back(row);
  }
  Eigen::VectorXd shares = Eigen::VectorXd::Unit(count, 0);
  if (rows.empty()) return shares;
  shares.setConstant(1.0 / static_cast<double>(count));
  constexpr int kReweightings = 8;
  constexpr double kHuber = 1.0;  // median distances
  std::vector<double> weights(rows.size(), 1.0);
  for (int turn = 0; turn < kReweightings; ++turn) {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(count, count);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      // Errors, not places: shares are 1 together.
      Eigen::MatrixXd errors(count, measured.cols());
      for (Eigen::Index m = 0; m < count; ++m)
        errors.row(m) = said[static_cast<std::size_t>(m)].row(rows[k]) - measured.row(rows[k]);
      normal += weights[k] * errors * errors.transpose();
    }
    shares = least_error_shares(normal, shares);
    std::vector<double> distances;
    for (const Eigen::Index row : rows) {
      Eigen::RowVectorXd error = -measured.row(row);
      for (Eigen::Index m = 0; m < count; ++m)
        error += shares[m] * said[static_cast<std::size_t>(m)].row(row);
      distances.push_back(error.norm());
    }
    const double bend = kHuber * median(distances);
    for (std::size_t k = 0; k < rows.size(); ++k)
      weights[k] = distances[k] <= bend ? 1.0 : bend / distances[k];
  }
  return shares;
}

Eigen::MatrixXd weighted(std::span<const Eigen::MatrixXd> said, const Eigen::VectorXd& shares) {
  if (said.empty() || std::ssize(said) != shares.size()) {
    throw ArgumentError(fmt::format("{} shares of {} predictors; as many were expected, and one or more",
                                    shares.size(), said.size()));
  }
  check_shapes(said, said.front().rows(), said.front().cols());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(said.front().rows(), said.front().cols());
  for (Eigen::Index row = 0; row < sum.rows(); ++row) {
    double together = 0.0;
    for (std::size_t m = 0; m < said.size(); ++m) {
      const double share = shares[static_cast<Eigen::Index>(m)];
      if (!(share > 0.0) || !said[m].row(row).allFinite()) continue;
      sum.row(row) += share * said[m].row(row);
      together += share;
    }
    sum.row(row) /= together;  // 0/0 where none gives a forecast
  }
  return sum;
}

Eigen::VectorXd disagreement(std::span<const Eigen::MatrixXd> said) {
  if (said.empty()) throw ArgumentError("no predictor is to be compared; one or more were expected");
  check_shapes(said, said.front().rows(), said.front().cols());
  Eigen::VectorXd apart = Eigen::VectorXd::Zero(said.front().rows());
  for (Eigen::Index row = 0; row < apart.size(); ++row) {
    Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(said.front().cols());
    double count = 0.0, squares = 0.0;
    for (const Eigen::MatrixXd& one : said) {
      if (!one.row(row).allFinite()) continue;
      mean += one.row(row);
      ++count;
    }
    if (count < 2.0) continue;
    for (const Eigen::MatrixXd& one : said) {
      if (one.row(row).allFinite()) squares += (one.row(row) - mean / count).squaredNorm();
    }
    apart[row] = std::sqrt(squares / count);
  }
  return apart;
}

namespace {

/// How much the logarithm of an error's size grows with each sign, in units of its deviation: least squares, as if four
/// clusters more showed no growth.
Eigen::VectorXd growth_of(const Eigen::MatrixXd& signs, const Eigen::VectorXd& log_sizes,
                          std::size_t clusters) {
  constexpr double kClusters = 4.0;
  Eigen::MatrixXd normal = signs.transpose() * signs;
  normal.diagonal().array() += kClusters * static_cast<double>(signs.rows()) / static_cast<double>(clusters);
  return normal.ldlt().solve(signs.transpose() * (log_sizes.array() - log_sizes.mean()).matrix());
}

/// Two normals about 0 with the greatest likelihood, by expectation and maximisation.
void fit_two_normals(const std::vector<double>& errors, Eigen::Vector2d& weights,
                     Eigen::Vector2d& deviations) {
  double squares = 0.0;
  for (const double e : errors) squares += e * e;
  const double deviation = std::sqrt(squares / static_cast<double>(errors.size()));
  weights = {0.7, 0.3};
  deviations = {0.5 * deviation, 1.6 * deviation};
  if (!(deviation > 0.0)) return;
  constexpr int kTurns = 200;
  for (int turn = 0; turn < kTurns; ++turn) {
    Eigen::Vector2d counts = Eigen::Vector2d::Zero(), sums = Eigen::Vector2d::Zero();
    for (const double e : errors) {
      const Eigen::Array2d z = e / deviations.array();
      // The smaller exponent is taken out: far errors have no density otherwise.
      const Eigen::Array2d exponents = -0.5 * z.square();
      Eigen::Vector2d of_each =
          (weights.array() / deviations.array() * (exponents - exponents.maxCoeff()).exp()).matrix();
      of_each /= of_each.sum();
      counts += of_each;
      sums += e * e * of_each;
    }
    weights = counts / counts.sum();
    // Neither shrinks onto a few errors that happen to be small.
    constexpr double kNarrowest = 0.1;
    for (int k = 0; k < 2; ++k)
      deviations[k] =
          std::max(counts[k] > 0.0 ? std::sqrt(sums[k] / counts[k]) : deviation, kNarrowest * deviation);
  }
}

/// How much wider the 90 % band of Student's distribution is than a normal one: of few degrees of freedom by its
/// quantiles (none counts as one), else z = 1.645 in the expansion of Fisher and Cornish (Technometrics 2 (1960)
/// 209-225) to the fourth power of 1/freedom, which is within 5e-5.
double student_widening(std::size_t freedom) {
  constexpr double kNormal = 1.644854;  // quantiles at 95 %
  constexpr std::array kOfFew = {6.313752, 6.313752, 2.919986, 2.353363, 2.131847};
  if (freedom < kOfFew.size()) return kOfFew[freedom] / kNormal;
  const double part = 1.0 / static_cast<double>(freedom);
  return 1.0 + part * (0.92639 + part * (0.86343 + part * (0.5976 + part * 0.2638)));
}

}  // namespace

ErrorDistribution::Sign ErrorDistribution::sign_of(const Eigen::VectorXd& values) {
  constexpr double kOutside = 0.05;  // on each side
  std::vector<double> known;
  std::ranges::copy_if(values, std::back_inserter(known), [](double value) { return !std::isnan(value); });
  Sign sign;
  if (known.empty()) return sign;
  std::ranges::sort(known);
  const auto outside = static_cast<std::size_t>(kOutside * static_cast<double>(known.size()));
  sign.lower = known[outside];
  sign.upper = known[known.size() - 1 - outside];
  for (double& value : known) value = std::clamp(value, sign.lower, sign.upper);
  const Eigen::Map<const Eigen::ArrayXd> within(known.data(), std::ssize(known));
  sign.mean = within.mean();
  sign.deviation = std::sqrt((within - sign.mean).square().mean());
  return sign;
}

Eigen::RowVectorXd ErrorDistribution::standardised(const Eigen::RowVectorXd& signs) const {
  Eigen::RowVectorXd units = Eigen::RowVectorXd::Zero(std::ssize(signs_));
  for (Eigen::Index j = 0; j < signs.size(); ++j) {
    const Sign& sign = signs_[static_cast<std::size_t>(j)];
    if (std::isnan(signs[j]) || !(sign.deviation > 0.0)) continue;
    units[j] = (std::clamp(signs[j], sign.lower, sign.upper) - sign.mean) / sign.deviation;
  }
  return units;
}

ErrorDistribution ErrorDistribution::fit(const Eigen::MatrixXd& errors, const Components& components,
                                         const Eigen::MatrixXd& signs, const std::vector<int>& clusters) {
  if (!clusters.empty() && std::ssize(clusters) != errors.rows()) {
    throw ArgumentError(
        fmt::format("{} errors have {} clusters; as many were expected", errors.rows(), clusters.size()));
  }
  if (signs.cols() > 0 && signs.rows() != errors.rows()) {
    throw ArgumentError(
        fmt::format("{} errors have {} rows of signs; as many were expected", errors.rows(), signs.rows()));
  }
  std::vector<Eigen::Index> rows;
  for (Eigen::Index row = 0; row < errors.rows(); ++row) {
    if (errors.row(row).allFinite()) rows.push_back(row);
  }
  ErrorDistribution result;
  constexpr std::size_t kFewest = 3;
  if (rows.size() < kFewest) return result;
  Eigen::MatrixXd units(std::ssize(rows), signs.cols());
  for (Eigen::Index j = 0; j < signs.cols(); ++j) result.signs_.push_back(sign_of(signs(rows, j)));
  for (std::size_t k = 0; k < rows.size() && signs.cols() > 0; ++k)
    units.row(static_cast<Eigen::Index>(k)) = result.standardised(signs.row(rows[k]));
  std::set<int> of_these;
  for (const Eigen::Index row : rows)
    of_these.insert(clusters.empty() ? static_cast<int>(row) : clusters[static_cast<std::size_t>(row)]);
  std::vector<std::vector<int>> groups;
  if (!components.level.empty()) groups.push_back(components.level);
  result.kind_of_.resize(static_cast<std::size_t>(errors.cols()), 0);
  for (int c = 0; c < errors.cols(); ++c) {
    if (std::ranges::count(components.level, c) > 0) continue;
    result.kind_of_[static_cast<std::size_t>(c)] = groups.size();
    groups.push_back({c});
  }
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const std::vector<int>& columns = groups[g];
    Kind kind;
    const Eigen::MatrixXd own = errors(rows, columns);
    const bool is_level = !components.level.empty() && g == 0;
    if (!is_level) kind.mean = own.mean();
    // Errors that happen to be next to none would outweigh all others.
    constexpr double kLeastPart = 0.01;
    const Eigen::ArrayXd squares = (own.array() - kind.mean).square().rowwise().mean();
    const double least = std::max(kLeastPart * std::sqrt(squares.mean()), std::numeric_limits<double>::min());
    kind.growth = growth_of(units, squares.sqrt().max(least).log(), of_these.size());
    const Eigen::VectorXd scales = (units * kind.growth).array().exp();
    std::vector<double> all;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      for (Eigen::Index c = 0; c < own.cols(); ++c)
        all.push_back((own(static_cast<Eigen::Index>(k), c) - kind.mean) /
                      scales[static_cast<Eigen::Index>(k)]);
    }
    fit_two_normals(all, kind.weights, kind.deviations);
    kind.deviations *= student_widening(of_these.size() - 1);
    result.kinds_.push_back(kind);
  }
  return result;
}

NormalMixture ErrorDistribution::around(Eigen::Index component, double predicted,
                                        const Eigen::RowVectorXd& signs) const {
  if (component < 0 || component >= std::ssize(kind_of_)) {
    throw ArgumentError(
        fmt::format("component {} of an error distribution of {} components", component, kind_of_.size()));
  }
  if (signs.size() > 0 && signs.size() != std::ssize(signs_)) {
    throw ArgumentError(fmt::format("{} signs, where the training had {}", signs.size(), signs_.size()));
  }
  const Kind& kind = kinds_[kind_of_[static_cast<std::size_t>(component)]];
  const double scale = std::exp(standardised(signs).dot(kind.growth));
  return {kind.weights, Eigen::VectorXd::Constant(2, predicted + kind.mean), scale * kind.deviations};
}

}  // namespace samara::identification
