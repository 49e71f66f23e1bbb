#include "samara/identification/forecasts/local_shares.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

constexpr std::size_t kSharedParts = 5;
constexpr std::size_t kWithAll = kSharedParts;  ///< leaves out none
constexpr double kEverywhere = std::numeric_limits<double>::infinity();

/// The nearest point with elements of 0 or more that are 1 together (Held, Wolfe and Crowder, Math. Program. 6
/// (1974) 62-88).
Eigen::VectorXd onto_simplex(const Eigen::VectorXd& point) {
  std::vector<double> sorted(point.begin(), point.end());
  std::ranges::sort(sorted, std::greater<>());
  double sum = 0.0, shift = 0.0;
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    sum += sorted[k];
    const double candidate = (sum - 1.0) / static_cast<double>(k + 1);
    if (sorted[k] > candidate) shift = candidate;
  }
  return (point.array() - shift).max(0.0);
}

}  // namespace

// By projected gradients with momentum (Beck and Teboulle, SIAM J. Imaging Sci. 2 (2009) 183-202).
Eigen::VectorXd least_error_shares(const Eigen::MatrixXd& normal, const Eigen::VectorXd& guess) {
  constexpr int kMost = 5000;
  constexpr double kStill = 1e-9;
  const double steepest =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(normal, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
  if (!(steepest > 0.0)) return guess;
  Eigen::VectorXd shares = guess, ahead = guess;
  double momentum = 1.0;
  for (int k = 0; k < kMost; ++k) {
    const Eigen::VectorXd next = onto_simplex(ahead - normal * ahead / steepest);
    const Eigen::VectorXd step = next - shares;
    // Where momentum leads up again it begins anew (O'Donoghue and Candes, Found. Comput. Math. 15 (2015) 715-732).
    const bool leads_up = (ahead - next).dot(step) > 0.0;
    const double grown = leads_up ? 1.0 : 0.5 * (1.0 + std::sqrt(1.0 + 4.0 * momentum * momentum));
    ahead = next + (leads_up ? 0.0 : (momentum - 1.0) / grown) * step;
    momentum = grown;
    shares = next;
    if (step.lpNorm<Eigen::Infinity>() < kStill) break;
  }
  return shares;
}

LocalShares LocalShares::fit(std::span<const Eigen::MatrixXd> errors, const Eigen::MatrixXd& features,
                             const std::vector<int>& clusters) {
  if (std::ssize(errors) != features.rows() || errors.size() != clusters.size()) {
    throw ArgumentError(
        fmt::format("{} moments have {} rows of features and {} clusters; as many were expected",
                    errors.size(), features.rows(), clusters.size()));
  }
  LocalShares result;
  if (errors.empty()) return result;
  for (const int cluster : clusters) result.part_of_[cluster] = 0;
  std::size_t dealt = 0;  // as cards, in the order of their numbers
  for (auto& [cluster, part] : result.part_of_) part = dealt++ % kSharedParts;
  for (const int cluster : clusters) result.parts_.push_back(result.part_of_.at(cluster));
  const Eigen::RowVectorXd mean = features.colwise().mean();
  result.scatter_ =
      (features.rowwise() - mean).colwise().norm() / std::sqrt(static_cast<double>(features.rows()));
  for (double& one : result.scatter_) one = one > 0.0 ? one : 1.0;
  result.features_ = features * result.scatter_.cwiseInverse().asDiagonal();

  constexpr int kReweightings = 8;
  constexpr double kHuber = 1.0;  // median distances
  const Eigen::Index count = errors.front().rows();
  result.of_all_ = Eigen::VectorXd::Constant(count, 1.0 / static_cast<double>(count));
  std::vector<double> weights(errors.size(), 1.0);
  for (int turn = 0; turn < kReweightings; ++turn) {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(count, count);
    for (std::size_t k = 0; k < errors.size(); ++k) normal += weights[k] * errors[k] * errors[k].transpose();
    result.of_all_ = least_error_shares(normal, result.of_all_);
    std::vector<double> distances;
    for (const Eigen::MatrixXd& one : errors) distances.push_back((result.of_all_.transpose() * one).norm());
    const double bend = kHuber * median(distances);
    for (std::size_t k = 0; k < errors.size(); ++k)
      weights[k] = distances[k] <= bend ? 1.0 : bend / distances[k];
  }
  for (std::size_t k = 0; k < errors.size(); ++k)
    result.products_.push_back(weights[k] * errors[k] * errors[k].transpose());

  result.width_ = kEverywhere;
  result.best_.assign(kSharedParts + 1, 0);
  if (result.part_of_.size() < 2) return result;
  for (std::size_t part = 0; part <= kSharedParts; ++part) {
    Eigen::VectorXd alone = Eigen::VectorXd::Zero(count);
    for (std::size_t k = 0; k < errors.size(); ++k) {
      if (result.parts_[k] != part) alone += errors[k].rowwise().norm();
    }
    alone.minCoeff(&result.best_[part]);
  }
  double least = std::numeric_limits<double>::infinity();
  for (const double width : {kEverywhere, 2.0, 1.0, 0.5}) {
    std::vector<Eigen::VectorXd> found;
    for (std::size_t k = 0; k < errors.size(); ++k)
      found.push_back(result.found(features.row(static_cast<Eigen::Index>(k)), result.parts_[k], width));
    for (const double to_best : {0.0, 0.5, 1.0}) {
      double sum = 0.0;
      for (std::size_t k = 0; k < errors.size(); ++k)
        sum += (result.drawn(found[k], result.parts_[k], to_best).transpose() * errors[k]).norm();
      if (!(sum < least)) continue;
      least = sum;
      result.width_ = width;
      result.to_best_ = to_best;
    }
  }
  result.of_all_ = result.drawn(result.of_all_, kWithAll, result.to_best_);
  return result;
}

Eigen::VectorXd LocalShares::drawn(const Eigen::VectorXd& shares, std::size_t part, double to_best) const {
  return (1.0 - to_best) * shares + to_best * Eigen::VectorXd::Unit(shares.size(), best_[part]);
}

Eigen::VectorXd LocalShares::found(const Eigen::RowVectorXd& features, std::size_t part, double width) const {
  const Eigen::RowVectorXd here = features.cwiseQuotient(scatter_);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(of_all_.size(), of_all_.size());
  for (std::size_t k = 0; k < products_.size(); ++k) {
    if (parts_[k] == part) continue;
    constexpr double kFloor = 0.05;
    const double square = (features_.row(static_cast<Eigen::Index>(k)) - here).squaredNorm();
    const double weight = std::isinf(width) ? 1.0 : kFloor + std::exp(-0.5 * square / (width * width));
    normal += weight * products_[k];
  }
  return least_error_shares(normal, of_all_);
}

Eigen::VectorXd LocalShares::shares(const Eigen::RowVectorXd& features, std::size_t part) const {
  if (std::isinf(width_) && part == kWithAll) return of_all_;
  return drawn(found(features, part, width_), part, to_best_);
}

Eigen::VectorXd LocalShares::at(const Eigen::RowVectorXd& features) const {
  return of_all_.size() == 0 ? of_all_ : shares(features, kWithAll);
}

Eigen::VectorXd LocalShares::without(int cluster, const Eigen::RowVectorXd& features) const {
  const auto part = part_of_.find(cluster);
  return part == part_of_.end() ? at(features) : shares(features, part->second);
}

}  // namespace samara::identification
