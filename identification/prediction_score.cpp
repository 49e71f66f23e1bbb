#include "samara/identification/prediction_score.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/QR>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/medians.h"

namespace samara::identification {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr Eigen::Index kFewestAtEnd = 5;

int degree_of(Baseline baseline) {
  switch (baseline) {
    case Baseline::straight_line:
    case Baseline::constant_velocity:
      return 1;
    case Baseline::quadratic:
    case Baseline::constant_acceleration:
      return 2;
    case Baseline::cubic:
      return 3;
  }
  throw ArgumentError("a baseline of no known kind");
}

bool follows_end(Baseline baseline) {
  return baseline == Baseline::constant_velocity || baseline == Baseline::constant_acceleration;
}

void check(const SeenMotion& window, const Eigen::VectorXd& times) {
  if (window.positions.rows() != window.times.size()) {
    throw ArgumentError(fmt::format("a window of {} times has {} positions; as many were expected",
                                    window.times.size(), window.positions.rows()));
  }
  if (!window.times.allFinite() || !times.allFinite())
    throw ArgumentError("a time of a prediction is not finite; finite times were expected");
}

/// Powers of (time - origin)/length, times x (degree + 1).
Eigen::MatrixXd powers(const Eigen::VectorXd& times, int degree, double origin, double length) {
  Eigen::MatrixXd result(times.size(), degree + 1);
  result.col(0).setOnes();
  for (int k = 1; k <= degree; ++k)
    result.col(k) = result.col(k - 1).array() * (times.array() - origin) / length;
  return result;
}

/// Indices of the frames in which the component was seen; of the last third only, if asked.
std::vector<Eigen::Index> seen_frames(const Eigen::VectorXd& component, bool last_third) {
  std::vector<Eigen::Index> frames;
  for (Eigen::Index row = 0; row < component.size(); ++row) {
    if (std::isfinite(component[row])) frames.push_back(row);
  }
  if (!last_third) return frames;
  const auto count = static_cast<Eigen::Index>(frames.size());
  const Eigen::Index kept = std::min(count, std::max(kFewestAtEnd, count / 3));
  frames.erase(frames.begin(), frames.end() - kept);
  return frames;
}

Eigen::VectorXd predict_component(Baseline baseline, const Eigen::VectorXd& window_times,
                                  const Eigen::VectorXd& component, const Eigen::VectorXd& times) {
  const int degree = degree_of(baseline);
  const std::vector<Eigen::Index> frames = seen_frames(component, follows_end(baseline));
  if (static_cast<int>(frames.size()) <= degree) return Eigen::VectorXd::Constant(times.size(), kNaN);
  const Eigen::VectorXd t = window_times(frames);
  const double origin = t[t.size() - 1];
  const double length = std::max(t.maxCoeff() - t.minCoeff(), std::numeric_limits<double>::min());
  const Eigen::VectorXd values = component(frames);
  const Eigen::VectorXd polynomial = powers(t, degree, origin, length).colPivHouseholderQr().solve(values);
  return powers(times, degree, origin, length) * polynomial;
}

}  // namespace

std::string to_string(Baseline baseline) {
  switch (baseline) {
    case Baseline::straight_line:
      return "straight line";
    case Baseline::quadratic:
      return "quadratic";
    case Baseline::cubic:
      return "cubic";
    case Baseline::constant_velocity:
      return "constant velocity";
    case Baseline::constant_acceleration:
      return "constant acceleration";
  }
  throw ArgumentError("a baseline of no known kind");
}

const std::vector<Baseline>& all_baselines() {
  static const std::vector<Baseline> all = {Baseline::straight_line, Baseline::quadratic, Baseline::cubic,
                                            Baseline::constant_velocity, Baseline::constant_acceleration};
  return all;
}

Eigen::MatrixXd predict(Baseline baseline, const SeenMotion& window, const Eigen::VectorXd& times) {
  check(window, times);
  Eigen::MatrixXd result(times.size(), window.positions.cols());
  for (Eigen::Index c = 0; c < result.cols(); ++c)
    result.col(c) = predict_component(baseline, window.times, window.positions.col(c), times);
  return result;
}

std::vector<double> prediction_distances(const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& measured) {
  if (predicted.rows() != measured.rows() || predicted.cols() != measured.cols()) {
    throw ArgumentError(fmt::format("a prediction of {} x {} was compared with {} x {} measured values",
                                    predicted.rows(), predicted.cols(), measured.rows(), measured.cols()));
  }
  std::vector<double> distances;
  for (Eigen::Index row = 0; row < predicted.rows(); ++row) {
    const double distance = (predicted.row(row) - measured.row(row)).norm();
    if (std::isfinite(distance)) distances.push_back(distance);
  }
  return distances;
}

PredictionTally::PredictionTally(std::string predictor, std::string quantity, std::string unit)
    : score_{.predictor = std::move(predictor), .quantity = std::move(quantity), .unit = std::move(unit)} {}

void PredictionTally::add(const std::vector<double>& distances) {
  if (!distances.empty()) ++score_.captures;
  distances_.insert(distances_.end(), distances.begin(), distances.end());
}

PredictionScore PredictionTally::score() const {
  PredictionScore score = score_;
  score.count = static_cast<int>(distances_.size());
  score.median = score.rms = score.largest = kNaN;
  if (distances_.empty()) return score;
  double squares = 0.0;
  for (const double distance : distances_) squares += distance * distance;
  score.median = median(distances_);
  score.rms = std::sqrt(squares / score.count);
  score.largest = *std::ranges::max_element(distances_);
  return score;
}

}  // namespace samara::identification
