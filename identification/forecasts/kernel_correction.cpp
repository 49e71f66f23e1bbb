#include "samara/identification/forecasts/kernel_correction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

constexpr double kLengths[] = {0.5, 0.7, 1.0, 1.5};
constexpr double kFirstRidge = 0.3;
constexpr double kOtherRidges[] = {0.03, 1.0, 3.0};
constexpr double kFarthestValue = 4.0;  ///< median distances

void check_mirrored(std::span<const Mirrored> features, std::span<const Mirrored> values,
                    std::span<const std::size_t> parts) {
  if (features.size() != values.size() || features.size() != parts.size()) {
    throw ArgumentError(fmt::format("{} moments have {} values and {} parts; as many were expected",
                                    features.size(), values.size(), parts.size()));
  }
  for (const std::span<const Mirrored> all : {features, values}) {
    for (const Mirrored& one : all) {
      if (one.even.size() != all.front().even.size() || one.odd.size() != all.front().odd.size()) {
        throw ArgumentError(fmt::format(
            "a moment has {} even and {} odd numbers, where another has {} and {}; as many were expected",
            one.even.size(), one.odd.size(), all.front().even.size(), all.front().odd.size()));
      }
      if (!one.even.allFinite() || !one.odd.allFinite())
        throw ArgumentError("a moment has numbers that are not finite; finite ones were expected");
    }
  }
}

/// Rows of them, of chosen moments.
Eigen::MatrixXd rows_of(std::span<const Mirrored> all, const std::vector<std::size_t>& chosen,
                        Eigen::VectorXd Mirrored::*kind) {
  Eigen::MatrixXd rows(std::ssize(chosen), (all[chosen.front()].*kind).size());
  for (std::size_t k = 0; k < chosen.size(); ++k)
    rows.row(static_cast<Eigen::Index>(k)) = (all[chosen[k]].*kind).transpose();
  return rows;
}

/// At most `most`, whatever order they come in.
std::vector<std::size_t> chosen_moments(std::span<const Mirrored> features,
                                        std::span<const std::size_t> parts, Eigen::Index most) {
  std::vector<std::size_t> order(features.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    if (parts[a] != parts[b]) return parts[a] < parts[b];
    if (features[a].even != features[b].even)
      return std::ranges::lexicographical_compare(features[a].even, features[b].even);
    return std::ranges::lexicographical_compare(features[a].odd, features[b].odd);
  });
  if (std::ssize(order) <= most) return order;
  std::vector<std::size_t> chosen;
  for (Eigen::Index k = 0; k < most; ++k)
    chosen.push_back(order[static_cast<std::size_t>(k * std::ssize(order) / most)]);
  return chosen;
}

Eigen::MatrixXd square_distances(const Eigen::MatrixXd& rows, const Eigen::MatrixXd& others) {
  Eigen::MatrixXd squares = -2.0 * rows * others.transpose();
  squares.colwise() += rows.rowwise().squaredNorm();
  squares.rowwise() += others.rowwise().squaredNorm().transpose();
  return squares.cwiseMax(0.0);
}

/// Kernels of even and of odd values between moments and centres.
struct Kernels {
  Eigen::MatrixXd even, odd;
};

/// @param count of features
Kernels kernels_of(const Eigen::MatrixXd& even_squares, const Eigen::MatrixXd& odd,
                   const Eigen::MatrixXd& odd_centres, double count, double length) {
  const double scale = -0.5 / (count * length * length);
  const Eigen::ArrayXXd as_seen = (scale * (even_squares + square_distances(odd, odd_centres))).array().exp();
  const Eigen::ArrayXXd mirrored =
      (scale * (even_squares + square_distances(odd, -odd_centres))).array().exp();
  return {(as_seen + mirrored).matrix(), (as_seen - mirrored).matrix()};
}

/// Coefficients of one kind of values by all moments and without each part, and what these say of the part.
struct Solution {
  Eigen::MatrixXd all = {};
  std::vector<Eigen::MatrixXd> without = {};
  Eigen::MatrixXd foretold = {};
};

/// With A the inverse of K + r, moments P of a part and c = A y: coefficients without the part are
/// c - A_P (A_PP)^-1 c_P, and what they say of the part is y_P - (A_PP)^-1 c_P.
Solution solve_ridge(Eigen::MatrixXd kernel, double ridge, const Eigen::MatrixXd& values,
                     const std::vector<std::vector<Eigen::Index>>& parts) {
  // Of no components Eigen's triangular solvers would read the first number.
  if (values.cols() == 0)
    return {.all = values, .without = std::vector<Eigen::MatrixXd>(parts.size(), values), .foretold = values};
  kernel.diagonal().array() += ridge;
  const Eigen::LLT<Eigen::MatrixXd> factors(kernel);
  const Eigen::Index count = kernel.rows();
  const Eigen::MatrixXd inverse = factors.solve(Eigen::MatrixXd::Identity(count, count));
  Solution solution{.all = inverse * values, .foretold = values};
  for (const std::vector<Eigen::Index>& part : parts) {
    const Eigen::MatrixXd block = inverse(part, part);
    const Eigen::MatrixXd missed = block.llt().solve(Eigen::MatrixXd(solution.all(part, Eigen::all)));
    Eigen::MatrixXd without = solution.all - inverse(Eigen::all, part) * missed;
    for (const Eigen::Index row : part) without.row(row).setZero();
    solution.without.push_back(std::move(without));
    solution.foretold(part, Eigen::all) -= missed;
  }
  return solution;
}

/// The same with fewer centres than moments: c with the least |y - K c|^2 + r c . K_mm c, K the kernel between moments
/// and centres, K_mm that of the centres. With all moments as centres these are the coefficients above.
Solution solve_by_centres(const Eigen::MatrixXd& kernel, const std::vector<Eigen::Index>& centres,
                          double ridge, const Eigen::MatrixXd& values,
                          const std::vector<std::vector<Eigen::Index>>& parts) {
  constexpr double kRoundOff = 1e-9;  // of the mean diagonal: centres may lie close together
  const Eigen::MatrixXd of_centres = kernel(centres, Eigen::all);
  const Eigen::MatrixXd right = kernel.transpose() * values;
  Eigen::MatrixXd normal = kernel.transpose() * kernel + ridge * of_centres;
  normal.diagonal().array() += kRoundOff * normal.diagonal().mean();
  Solution solution{.all = normal.llt().solve(right), .foretold = values};
  for (const std::vector<Eigen::Index>& part : parts) {
    const Eigen::MatrixXd of_part = kernel(part, Eigen::all);
    const Eigen::MatrixXd left = normal - of_part.transpose() * of_part;
    solution.without.push_back(left.llt().solve(right - of_part.transpose() * values(part, Eigen::all)));
    solution.foretold(part, Eigen::all) = of_part * solution.without.back();
  }
  return solution;
}

}  // namespace

/// A correction that is being fitted, and what it is fitted to.
struct KernelCorrection::Steps {
  KernelCorrection correction = {};
  std::vector<std::vector<Eigen::Index>> members = {};  ///< moments of each part
  Eigen::MatrixXd even = {}, odd = {};                  ///< values
  std::vector<Eigen::Index> centres = {};               ///< moments that are centres, too
  Eigen::MatrixXd odd_rows = {};      ///< odd features of all moments, in units of their deviation
  Eigen::VectorXd drawn_in = {};      ///< of each moment, what far values are multiplied by
  Eigen::MatrixXd even_squares = {};  ///< of distances from moments to centres
  double uncorrected = 0.0;           ///< sum of distances from 0

  static Steps begin(std::span<const Mirrored> features, std::span<const Mirrored> values,
                     std::span<const std::size_t> parts, Eigen::Index most, Eigen::Index most_centres);
  void set_centres(const Eigen::MatrixXd& even_features, const Eigen::MatrixXd& odd_features);
  /// Whether parts could be told from each other, and features too.
  bool can_choose() const;
  /// @returns the sum of distances that is left when parts foretell the others
  double solve_with(double length, double ridge);
};

KernelCorrection::Steps KernelCorrection::Steps::begin(std::span<const Mirrored> features,
                                                       std::span<const Mirrored> values,
                                                       std::span<const std::size_t> parts, Eigen::Index most,
                                                       Eigen::Index most_centres) {
  Steps steps;
  const std::vector<std::size_t> chosen = chosen_moments(features, parts, most);
  steps.correction.even_values_ = values.front().even.size();
  steps.correction.odd_values_ = values.front().odd.size();
  steps.members.resize(*std::ranges::max_element(parts) + 1);
  for (std::size_t k = 0; k < chosen.size(); ++k)
    steps.members[parts[chosen[k]]].push_back(static_cast<Eigen::Index>(k));
  const Eigen::Index count = std::ssize(chosen), centres = std::min(count, most_centres);
  for (Eigen::Index k = 0; k < centres; ++k) steps.centres.push_back(k * count / centres);
  steps.set_centres(rows_of(features, chosen, &Mirrored::even), rows_of(features, chosen, &Mirrored::odd));
  steps.even = rows_of(values, chosen, &Mirrored::even);
  steps.odd = rows_of(values, chosen, &Mirrored::odd);
  const Eigen::VectorXd distances =
      (steps.even.rowwise().squaredNorm() + steps.odd.rowwise().squaredNorm()).cwiseSqrt();
  const double farthest = kFarthestValue * median({distances.begin(), distances.end()});
  steps.drawn_in =
      distances.unaryExpr([&](double distance) { return distance > farthest ? farthest / distance : 1.0; });
  steps.uncorrected = distances.sum();
  return steps;
}

void KernelCorrection::Steps::set_centres(const Eigen::MatrixXd& even_features,
                                          const Eigen::MatrixXd& odd_features) {
  const double root = std::sqrt(static_cast<double>(even_features.rows()));
  correction.middle_ = even_features.colwise().mean();
  correction.even_width_ = (even_features.rowwise() - correction.middle_).colwise().norm() / root;
  correction.odd_width_ = odd_features.colwise().norm() / root;
  // What does not vary says nothing: in units of infinity it is 0.
  const auto count_or_silence = [&](double& width, double size) {
    constexpr double kStill = 1e-12;
    if (width > kStill * std::abs(size)) {
      ++correction.count_;
    } else {
      width = std::numeric_limits<double>::infinity();
    }
  };
  for (Eigen::Index k = 0; k < correction.middle_.size(); ++k)
    count_or_silence(correction.even_width_[k], correction.middle_[k]);
  for (double& width : correction.odd_width_) count_or_silence(width, 0.0);
  const Eigen::MatrixXd even_rows =
      (even_features.rowwise() - correction.middle_) * correction.even_width_.cwiseInverse().asDiagonal();
  odd_rows = odd_features * correction.odd_width_.cwiseInverse().asDiagonal();
  correction.centres_ = {even_rows(centres, Eigen::all), odd_rows(centres, Eigen::all)};
  even_squares = square_distances(even_rows, correction.centres_.even);
}

bool KernelCorrection::Steps::can_choose() const {
  return correction.count_ > 0.0 &&
         std::ranges::count_if(members, [](const auto& part) { return !part.empty(); }) > 1;
}

double KernelCorrection::Steps::solve_with(double length, double ridge) {
  const Kernels kernels =
      kernels_of(even_squares, odd_rows, correction.centres_.odd, correction.count_, length);
  const auto solve = [&](const Eigen::MatrixXd& kernel, const Eigen::MatrixXd& values) {
    return kernel.rows() == kernel.cols() ? solve_ridge(kernel, ridge, values, members)
                                          : solve_by_centres(kernel, centres, ridge, values, members);
  };
  Solution of_even = solve(kernels.even, drawn_in.asDiagonal() * even);
  Solution of_odd = solve(kernels.odd, drawn_in.asDiagonal() * odd);
  correction.length_ = length;
  correction.ridge_ = ridge;
  correction.coefficients_ = {std::move(of_even.all), std::move(of_odd.all)};
  correction.without_.clear();
  for (std::size_t part = 0; part < members.size(); ++part)
    correction.without_.push_back({std::move(of_even.without[part]), std::move(of_odd.without[part])});
  return ((even - of_even.foretold).rowwise().squaredNorm() + (odd - of_odd.foretold).rowwise().squaredNorm())
      .cwiseSqrt()
      .sum();
}

KernelCorrection KernelCorrection::fit(std::span<const Mirrored> features, std::span<const Mirrored> values,
                                       std::span<const std::size_t> parts) {
  check_mirrored(features, values, parts);
  if (features.empty()) return {};
  Steps few = Steps::begin(features, values, parts, kChoosing, kChoosing);
  KernelCorrection none = few.correction;
  if (!few.can_choose()) return none;
  double least = few.uncorrected, length = 0.0, ridge = 0.0;
  const auto attempt = [&](double tried_length, double tried_ridge) {
    const double left = few.solve_with(tried_length, tried_ridge);
    if (!(left < least)) return;
    least = left;
    length = tried_length;
    ridge = tried_ridge;
  };
  for (const double tried : kLengths) attempt(tried, kFirstRidge);
  if (length == 0.0) return none;
  for (const double tried : kOtherRidges) attempt(length, tried);
  const Eigen::Index count = std::ssize(features);
  if (count > kChoosing)
    few = Steps::begin(features, values, parts, kMost, count > kExact ? kCentres : kExact);
  return few.solve_with(length, ridge) < few.uncorrected ? few.correction : none;
}

KernelCorrection::Centres KernelCorrection::scaled(const Mirrored& features) const {
  return {(features.even.transpose() - middle_) * even_width_.cwiseInverse().asDiagonal(),
          features.odd.transpose() * odd_width_.cwiseInverse().asDiagonal()};
}

Mirrored KernelCorrection::values_at(const Coefficients& coefficients, const Mirrored& features) const {
  const Centres here = scaled(features);
  const Kernels kernels =
      kernels_of(square_distances(here.even, centres_.even), here.odd, centres_.odd, count_, length_);
  return {(kernels.even * coefficients.even).transpose(), (kernels.odd * coefficients.odd).transpose()};
}

Mirrored KernelCorrection::at(const Mirrored& features) const {
  if (!is_fitted()) return {Eigen::VectorXd::Zero(even_values_), Eigen::VectorXd::Zero(odd_values_)};
  return values_at(coefficients_, features);
}

Mirrored KernelCorrection::without(std::size_t part, const Mirrored& features) const {
  if (!is_fitted() || part >= without_.size()) return at(features);
  return values_at(without_[part], features);
}

}  // namespace samara::identification
