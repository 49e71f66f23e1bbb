#include "samara/identification/forecasts/turning_prediction.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <set>
#include <vector>

#include <Eigen/QR>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

constexpr Eigen::Index kDegrees = 6, kDegreesInKernel = 4;
constexpr std::size_t kFewestMotions = 12;
constexpr double kFarthestMiss = 4.0;  // median distances

/// Orthogonal polynomials of degree 0 and more on so many places, a row each, their squares 1 together.
/// @param degree the highest
Eigen::MatrixXd orthogonal_polynomials(Eigen::Index places, Eigen::Index degree) {
  const Eigen::Index degrees = std::min(degree, places - 1);
  Eigen::MatrixXd powers(places, degrees + 1);
  powers.col(0).setOnes();
  const Eigen::ArrayXd at = Eigen::ArrayXd::LinSpaced(places, -1.0, 1.0);
  for (Eigen::Index k = 1; k <= degrees; ++k) powers.col(k) = powers.col(k - 1).array() * at;
  const Eigen::HouseholderQR<Eigen::MatrixXd> factors(powers);
  const Eigen::MatrixXd all = factors.householderQ() * Eigen::MatrixXd::Identity(places, degrees + 1);
  return all.transpose();
}

/// @param displacements a row each
Turning turning_of(const Eigen::MatrixXd& displacements, const Components& components) {
  const std::vector<int> others = others_of(components, displacements.cols());
  Turning numbers{.level = Eigen::VectorXcd(displacements.rows()),
                  .others = displacements(Eigen::all, others).reshaped()};
  numbers.level.real() = displacements.col(components.level[0]);
  numbers.level.imag() = displacements.col(components.level[1]);
  return numbers;
}

/// The one displacement of which these are the numbers.
Eigen::RowVectorXd displacement_of(const Turning& numbers, const Components& components) {
  Eigen::RowVectorXd displacement(numbers.others.size() + 2);
  displacement(others_of(components, displacement.size())) = numbers.others.transpose();
  displacement[components.level[0]] = numbers.level[0].real();
  displacement[components.level[1]] = numbers.level[0].imag();
  return displacement;
}

/// Polynomials of the components that do not turn say less of what comes than those of the ones that do.
CovariantRegression::Weights weights_of(Eigen::Index degrees, Eigen::Index others, Eigen::Index known,
                                        Eigen::Index views) {
  constexpr double kOfOthers = 1.0 / 3.0;
  const Eigen::Index seen = std::min(kDegreesInKernel, degrees);
  CovariantRegression::Weights weights{.level = Eigen::VectorXd::Zero(degrees),
                                       .others = Eigen::VectorXd::Ones(others * degrees + known),
                                       .views = Eigen::VectorXd::Constant(views, kOfOthers)};
  weights.level.head(seen).setOnes();
  for (Eigen::Index k = 0; k < others; ++k) {
    weights.others.segment(k * degrees, degrees).setZero();
    weights.others.segment(k * degrees, seen).setConstant(kOfOthers);
  }
  return weights;
}

}  // namespace

Eigen::MatrixXcd TurningPrediction::views_of(const SeenMotion& seen) const {
  return views_back(seen, Eigen::VectorXd::LinSpaced(polynomials_.cols(), way_back_, 0.0));
}

bool TurningPrediction::is_shown_by(const SeenMotion& seen) const {
  return !sees_views() || (seen.views.cols() == views_ && views_of(seen).allFinite());
}

Turning TurningPrediction::features_of(const SeenMotion& seen, const Eigen::VectorXd& known) const {
  const Eigen::VectorXd intervals = Eigen::VectorXd::LinSpaced(polynomials_.cols(), way_back_, 0.0);
  Turning features = turning_of(polynomials_ * places_back(seen, intervals), components_);
  if (sees_views())
    features.views = (view_polynomials_.cast<std::complex<double>>() * views_of(seen)).reshaped();
  const Eigen::Index count = features.others.size();
  features.others.conservativeResize(count + known.size());
  features.others.tail(known.size()) = known;
  return features;
}

TurningPrediction TurningPrediction::fit(std::span<const TurningMoment> moments, const Components& components,
                                         double way_back) {
  if (components.level.size() != 2) {
    throw ArgumentError(
        fmt::format("a turning prediction of {} level components; 2 were expected", components.level.size()));
  }
  std::set<int> motions;
  for (const TurningMoment& one : moments) motions.insert(one.motion);
  if (motions.size() < kFewestMotions) return {};
  TurningPrediction blind;
  blind.components_ = components;
  blind.way_back_ = way_back;
  const auto places = static_cast<Eigen::Index>(std::ceil(way_back)) + 1;
  blind.polynomials_ = orthogonal_polynomials(places, kDegrees).bottomRows(std::min(kDegrees, places - 1));
  TurningPrediction viewing = blind;
  viewing.views_ = moments.front().seen->views.cols();
  viewing.view_polynomials_ = orthogonal_polynomials(places, kDegreesInKernel);
  const bool all_show =
      std::ranges::all_of(moments, [&](const TurningMoment& one) { return viewing.is_shown_by(*one.seen); });
  const double by_places = blind.learn(moments);
  const double by_views = viewing.views_ > 0 && all_show ? viewing.learn(moments) : 0.0;
  if (std::max(by_places, by_views) <= 0.0) return {};
  return by_views > by_places ? viewing : blind;
}

double TurningPrediction::learn(std::span<const TurningMoment> moments) {
  std::vector<double> distances;
  for (const TurningMoment& one : moments) distances.push_back(one.missed.norm());
  const double farthest = kFarthestMiss * median(distances);
  std::vector<Turning> features, wanted;
  std::vector<std::size_t> parts;
  for (std::size_t k = 0; k < moments.size(); ++k) {
    const TurningMoment& one = moments[k];
    const double drawn_in = distances[k] > farthest ? farthest / distances[k] : 1.0;
    features.push_back(features_of(*one.seen, *one.known));
    wanted.push_back(turning_of(one.moved - (1.0 - drawn_in) * one.missed, components_));
    parts.push_back(one.part);
  }
  const TurningMoment& first = moments.front();
  regression_ = CovariantRegression::fit(features, wanted, parts,
                                         weights_of(polynomials_.rows(), first.moved.size() - 2,
                                                    first.known->size(), features.front().views.size()));
  if (!is_fitted()) return 0.0;
  double gained = 0.0;
  for (std::size_t k = 0; k < moments.size(); ++k) {
    const Eigen::RowVectorXd missed =
        moments[k].moved - displacement_of(regression_.without(parts[k], features[k]), components_);
    gained += distances[k] - ((1.0 - share()) * moments[k].missed + share() * missed).norm();
  }
  return gained;
}

void TurningPrediction::check_asked(const SeenMotion& seen) const {
  if (!is_fitted()) throw ArgumentError("a turning prediction was asked before it was fitted");
  if (seen.positions.cols() > *std::ranges::max_element(components_.level)) return;
  throw ArgumentError(fmt::format(
      "a motion of {} components was asked about; level components {} and {} were expected among them",
      seen.positions.cols(), components_.level[0], components_.level[1]));
}

Eigen::RowVectorXd TurningPrediction::moved(const SeenMotion& seen, const Eigen::VectorXd& known) const {
  check_asked(seen);
  return displacement_of(regression_.at(features_of(seen, known)), components_);
}

Eigen::RowVectorXd TurningPrediction::moved_without(std::size_t part, const SeenMotion& seen,
                                                    const Eigen::VectorXd& known) const {
  check_asked(seen);
  return displacement_of(regression_.without(part, features_of(seen, known)), components_);
}

}  // namespace samara::identification
