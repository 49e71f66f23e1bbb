#include "samara/identification/forecasts/covariant_regression.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::identification {

namespace {

constexpr double kLengthsTried[] = {1.0, 1.4, 2.0, 2.8, 4.0};
constexpr double kRidgeAtFirst = 0.1;
constexpr double kRidgesTried[] = {0.03, 0.3, 1.0};
constexpr double kOfLinear = 1.0 / 30.0;  ///< of the ridge

void check_turning(std::span<const Turning> features, std::span<const Turning> values,
                   std::span<const std::size_t> parts, const CovariantRegression::Weights& weights) {
  if (features.size() != values.size() || features.size() != parts.size()) {
    throw ArgumentError(fmt::format("{} moments have {} values and {} parts; as many were expected",
                                    features.size(), values.size(), parts.size()));
  }
  const auto check = [](const Turning& one, Eigen::Index level, Eigen::Index others, Eigen::Index views) {
    if (one.level.size() != level || one.others.size() != others || one.views.size() != views) {
      throw ArgumentError(
          fmt::format("a moment has {} level numbers, {} others and {} of views; {}, {} and {} were expected",
                      one.level.size(), one.others.size(), one.views.size(), level, others, views));
    }
    if (!one.level.allFinite() || !one.others.allFinite() || !one.views.allFinite())
      throw ArgumentError("a moment has numbers that are not finite; finite ones were expected");
  };
  for (const Turning& one : features)
    check(one, weights.level.size(), weights.others.size(), weights.views.size());
  for (const Turning& one : values) check(one, values.front().level.size(), values.front().others.size(), 0);
}

/// At most `most`, whatever order they come in and however they are turned.
std::vector<std::size_t> every_so_many(std::span<const Turning> features, std::span<const std::size_t> parts,
                                       Eigen::Index most) {
  std::vector<std::size_t> order(parts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    if (parts[a] != parts[b]) return parts[a] < parts[b];
    if (features[a].others != features[b].others)
      return std::ranges::lexicographical_compare(features[a].others, features[b].others);
    return features[a].level.squaredNorm() < features[b].level.squaredNorm();
  });
  const auto count = std::min(most, std::ssize(order));
  std::vector<std::size_t> chosen;
  for (Eigen::Index k = 0; k < count; ++k)
    chosen.push_back(order[static_cast<std::size_t>(k * std::ssize(order) / count)]);
  return chosen;
}

template <typename Vector>
auto rows_of(std::span<const Turning> all, const std::vector<std::size_t>& chosen, Vector Turning::*kind) {
  Eigen::Matrix<typename Vector::Scalar, Eigen::Dynamic, Eigen::Dynamic> rows(std::ssize(chosen),
                                                                              (all.front().*kind).size());
  for (std::size_t k = 0; k < chosen.size(); ++k)
    rows.row(static_cast<Eigen::Index>(k)) = (all[chosen[k]].*kind).transpose();
  return rows;
}

Eigen::MatrixXd real_above_imaginary(const Eigen::MatrixXcd& values) {
  Eigen::MatrixXd rows(2 * values.rows(), values.cols());
  rows << values.real(), values.imag();
  return rows;
}

/// Coefficients by all moments and without each part, and what these leave of the part's values.
struct PartSolution {
  Eigen::MatrixXd all = {};
  std::vector<Eigen::MatrixXd> without = {};
  Eigen::MatrixXd left = {};
};

/// NaN where the matrix is not positive definite: round-off has eaten the penalty.
Eigen::MatrixXd solved(const Eigen::MatrixXd& normal, const Eigen::MatrixXd& right) {
  const Eigen::LLT<Eigen::MatrixXd> factors(normal);
  if (factors.info() == Eigen::Success) return factors.solve(right);
  return Eigen::MatrixXd::Constant(right.rows(), right.cols(), std::numeric_limits<double>::quiet_NaN());
}

/// @param members rows of the terms that belong to each part
PartSolution solve_parts(const Eigen::MatrixXd& terms, const Eigen::MatrixXd& penalty,
                         const Eigen::MatrixXd& values,
                         const std::vector<std::vector<Eigen::Index>>& members) {
  constexpr double kRoundOff = 1e-10;  // of the mean diagonal: centres may lie close together
  std::vector<Eigen::MatrixXd> normals, rights;
  Eigen::MatrixXd normal = penalty, right = Eigen::MatrixXd::Zero(terms.cols(), values.cols());
  for (const std::vector<Eigen::Index>& part : members) {
    const Eigen::MatrixXd of_part = terms(part, Eigen::all);
    normals.push_back(of_part.transpose() * of_part);
    rights.push_back(of_part.transpose() * values(part, Eigen::all));
    normal += normals.back();
    right += rights.back();
  }
  normal.diagonal().array() += kRoundOff * normal.diagonal().mean();
  PartSolution solution{.all = solved(normal, right), .left = values};
  for (std::size_t part = 0; part < members.size(); ++part) {
    solution.without.push_back(solved(normal - normals[part], right - rights[part]));
    solution.left(members[part], Eigen::all) -= terms(members[part], Eigen::all) * solution.without.back();
  }
  return solution;
}

}  // namespace

/// A regression that is being fitted, and what it is fitted to.
struct CovariantRegression::Steps {
  CovariantRegression regression = {};
  TurningRows rows = {};
  Eigen::MatrixXd level_values = {};  ///< real parts above imaginary ones
  Eigen::MatrixXd other_values = {};
  std::vector<std::vector<Eigen::Index>> level_members = {}, other_members = {};  ///< rows of each part

  static Steps begin(std::span<const Turning> features, std::span<const Turning> values,
                     std::span<const std::size_t> parts, const Weights& weights, Eigen::Index most,
                     Eigen::Index most_centres);
  /// Both set the regression's coefficients. @returns the sum of distances left when parts foretell the others; NaN
  /// where there is no solution
  double solve_level(double length, double ridge);
  double solve_others(double length, double ridge);
};

CovariantRegression::Steps CovariantRegression::Steps::begin(std::span<const Turning> features,
                                                             std::span<const Turning> values,
                                                             std::span<const std::size_t> parts,
                                                             const Weights& weights, Eigen::Index most,
                                                             Eigen::Index most_centres) {
  Steps steps;
  const std::vector<std::size_t> chosen = every_so_many(features, parts, most);
  const TurningRows seen{rows_of(features, chosen, &Turning::level),
                         rows_of(features, chosen, &Turning::others),
                         rows_of(features, chosen, &Turning::views)};
  const double count = static_cast<double>(chosen.size());
  // What does not vary, beside its size or beside others of its kind, says nothing: in units of infinity it is 0.
  const auto or_silence = [](const Eigen::RowVectorXd& widths, const Eigen::RowVectorXd& sizes) {
    constexpr double kStill = 1e-12;
    const double widest = widths.size() > 0 ? widths.maxCoeff() : 0.0;
    return Eigen::RowVectorXd((widths.array() > kStill * sizes.array().max(widest))
                                  .select(widths, std::numeric_limits<double>::infinity()));
  };
  CovariantRegression& regression = steps.regression;
  regression.weights_ = weights;
  // Of level numbers about 0, of those of both views about their common mean.
  const auto width_of_both = [&](const Eigen::MatrixXcd& both, const Eigen::RowVectorXd& sizes) {
    return or_silence((both.cwiseAbs2().colwise().sum() / (2.0 * count)).cwiseSqrt(), sizes);
  };
  regression.level_width_ = width_of_both(seen.level, Eigen::RowVectorXd::Zero(seen.level.cols()));
  regression.middle_ = seen.others.colwise().mean();
  regression.width_ =
      or_silence((seen.others.rowwise() - regression.middle_).colwise().norm() / std::sqrt(count),
                 regression.middle_.cwiseAbs());
  const Eigen::RowVectorXcd of_views = seen.views.colwise().mean();
  regression.view_middle_ = 0.5 * (of_views.real() + of_views.imag());
  regression.view_width_ =
      width_of_both(seen.views.rowwise() - regression.in_both_views(), regression.view_middle_.cwiseAbs());
  steps.rows = regression.scaled(seen);
  std::vector<Eigen::Index> centres;
  const Eigen::Index rows = std::ssize(chosen), many = std::min(rows, most_centres);
  for (Eigen::Index k = 0; k < many; ++k) centres.push_back(k * rows / many);
  regression.centres_ = {steps.rows.level(centres, Eigen::all), steps.rows.others(centres, Eigen::all),
                         steps.rows.views(centres, Eigen::all)};
  steps.level_values = real_above_imaginary(rows_of(values, chosen, &Turning::level));
  steps.other_values = rows_of(values, chosen, &Turning::others);
  steps.other_members.resize(*std::ranges::max_element(parts) + 1);
  for (std::size_t k = 0; k < chosen.size(); ++k)
    steps.other_members[parts[chosen[k]]].push_back(static_cast<Eigen::Index>(k));
  steps.level_members = steps.other_members;
  for (std::vector<Eigen::Index>& part : steps.level_members) {
    const auto of_part = part;
    for (const Eigen::Index row : of_part) part.push_back(row + rows);
  }
  return steps;
}

double CovariantRegression::Steps::solve_level(double length, double ridge) {
  const Eigen::MatrixXd terms = regression.level_terms(rows, length);
  Eigen::MatrixXd penalty = Eigen::MatrixXd::Zero(terms.cols(), terms.cols());
  const Eigen::Index linear = rows.level.cols(), bent = terms.cols() - linear;
  penalty.diagonal().head(linear).setConstant(ridge * kOfLinear);
  penalty.bottomRightCorner(bent, bent) =
      ridge * regression.level_terms(regression.centres_, length).rightCols(bent);
  PartSolution solution = solve_parts(terms, penalty, level_values, level_members);
  regression.level_ = {length, ridge, std::move(solution.all), std::move(solution.without)};
  const Eigen::VectorXd squares = solution.left.rowwise().squaredNorm();
  const Eigen::Index count = squares.size() / 2;
  return (squares.head(count) + squares.tail(count)).cwiseSqrt().sum();
}

double CovariantRegression::Steps::solve_others(double length, double ridge) {
  const Eigen::MatrixXd terms = regression.other_terms(rows, length);
  Eigen::MatrixXd penalty = Eigen::MatrixXd::Zero(terms.cols(), terms.cols());
  const Eigen::Index linear = rows.others.cols() + rows.views.cols(), bent = terms.cols() - linear - 1;
  penalty.diagonal().segment(1, linear).setConstant(ridge * kOfLinear);
  penalty.bottomRightCorner(bent, bent) =
      ridge * regression.other_terms(regression.centres_, length).rightCols(bent);
  PartSolution solution = solve_parts(terms, penalty, other_values, other_members);
  regression.others_ = {length, ridge, std::move(solution.all), std::move(solution.without)};
  return solution.left.rowwise().norm().sum();
}

namespace {

struct Choice {
  double length = 0.0, ridge = 0.0;
};

/// @param left sum of distances that a length and a ridge leave
Choice chosen_by(const std::function<double(double, double)>& left) {
  Choice best;
  double least = std::numeric_limits<double>::infinity();
  const auto attempt = [&](double length, double ridge) {
    const double sum = left(length, ridge);
    if (!(sum < least)) return;
    least = sum;
    best = {length, ridge};
  };
  for (const double length : kLengthsTried) attempt(length, kRidgeAtFirst);
  const double length = best.length;
  for (const double ridge : kRidgesTried) attempt(length, ridge);
  return best;
}

}  // namespace

CovariantRegression CovariantRegression::fit(std::span<const Turning> features,
                                             std::span<const Turning> values,
                                             std::span<const std::size_t> parts, const Weights& weights) {
  check_turning(features, values, parts, weights);
  if (features.empty() || std::ranges::all_of(parts, [&](std::size_t part) { return part == parts[0]; }))
    return {};
  Steps few = Steps::begin(features, values, parts, weights, kChoosing, kChoosingCentres);
  if (std::ranges::count_if(few.other_members, [](const auto& part) { return !part.empty(); }) < 2) return {};
  const Choice level = chosen_by([&](double length, double ridge) { return few.solve_level(length, ridge); });
  const Choice others =
      chosen_by([&](double length, double ridge) { return few.solve_others(length, ridge); });
  if (!(level.length > 0.0 && others.length > 0.0)) return {};
  Steps all = Steps::begin(features, values, parts, weights, kMost, kCentres);
  const bool is_solved = std::isfinite(all.solve_level(level.length, level.ridge)) &&
                         std::isfinite(all.solve_others(others.length, others.ridge));
  return is_solved ? all.regression : CovariantRegression();
}

Eigen::RowVectorXcd CovariantRegression::in_both_views() const {
  return view_middle_.cast<std::complex<double>>() * std::complex<double>(1.0, 1.0);
}

TurningRows CovariantRegression::scaled(TurningRows rows) const {
  rows.level *= level_width_.cwiseInverse().cast<std::complex<double>>().asDiagonal();
  rows.others.rowwise() -= middle_;
  rows.others *= width_.cwiseInverse().asDiagonal();
  rows.views.rowwise() -= in_both_views();
  rows.views *= view_width_.cwiseInverse().cast<std::complex<double>>().asDiagonal();
  return rows;
}

TurningRows CovariantRegression::in_kernel(const TurningRows& rows, double length) const {
  return {rows.level * (weights_.level / length).cast<std::complex<double>>().asDiagonal(),
          rows.others * (weights_.others / length).asDiagonal(),
          rows.views * (weights_.views / length).cast<std::complex<double>>().asDiagonal()};
}

Eigen::MatrixXd CovariantRegression::level_terms(const TurningRows& rows, double length) const {
  const TurningKernel kernel = turning_kernel(in_kernel(rows, length), in_kernel(centres_, length));
  const Eigen::Index linear = rows.level.cols(), centres = centres_.level.rows();
  Eigen::MatrixXd terms(2 * rows.level.rows(), linear + 2 * centres);
  terms.leftCols(linear) = real_above_imaginary(rows.level);
  // Of real and imaginary parts of c_j.
  terms.middleCols(linear, centres) = real_above_imaginary(kernel.as_seen + kernel.mirrored);
  terms.rightCols(centres) =
      real_above_imaginary(std::complex<double>(0.0, 1.0) * (kernel.as_seen - kernel.mirrored));
  return terms;
}

Eigen::MatrixXd CovariantRegression::other_terms(const TurningRows& rows, double length) const {
  const Eigen::Index others = rows.others.cols(), views = rows.views.cols(), centres = centres_.others.rows();
  Eigen::MatrixXd terms(rows.others.rows(), 1 + others + views + centres);
  terms.col(0).setOnes();
  terms.middleCols(1, others) = rows.others;
  terms.middleCols(1 + others, views) = rows.views.real() + rows.views.imag();
  terms.rightCols(centres) = still_kernel(in_kernel(rows, length), in_kernel(centres_, length));
  return terms;
}

Turning CovariantRegression::values_at(const Turning& features, const Eigen::MatrixXd& level,
                                       const Eigen::MatrixXd& others) const {
  if (!is_fitted() || features.level.size() != level_width_.size() ||
      features.others.size() != width_.size() || features.views.size() != view_width_.size()) {
    throw ArgumentError(fmt::format(
        "a regression of {} level numbers, {} others and {} of views was asked about {}, {} and {}; as many "
        "were expected",
        level_width_.size(), width_.size(), view_width_.size(), features.level.size(), features.others.size(),
        features.views.size()));
  }
  const TurningRows here =
      scaled({features.level.transpose(), features.others.transpose(), features.views.transpose()});
  const Eigen::MatrixXd turning = level_terms(here, level_.length) * level;
  Turning values{.level = Eigen::VectorXcd(turning.cols())};
  values.level.real() = turning.row(0).transpose();
  values.level.imag() = turning.row(1).transpose();
  values.others = (other_terms(here, others_.length) * others).transpose();
  return values;
}

Turning CovariantRegression::at(const Turning& features) const {
  return values_at(features, level_.coefficients, others_.coefficients);
}

Turning CovariantRegression::without(std::size_t part, const Turning& features) const {
  if (part >= level_.without.size()) return at(features);
  return values_at(features, level_.without[part], others_.without[part]);
}

}  // namespace samara::identification
