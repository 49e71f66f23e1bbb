#include "samara/identification/forecasts/baseline_scores.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <Eigen/QR>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/streams.h"
#include "samara/identification/forecasts/point_with_drag.h"
#include "samara/identification/smoothing/continuous_angles.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/identification/smoothing/rotation_vectors.h"
#include "samara/identification/smoothing/smoothing.h"

namespace samara::identification {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr Eigen::Index kFewestAtEnd = 5;

int degree_of(Baseline baseline) {
  switch (baseline) {
    case Baseline::straight_line:
    case Baseline::constant_velocity:
    case Baseline::measured_velocity:
      return 1;
    case Baseline::quadratic:
    case Baseline::constant_acceleration:
      return 2;
    case Baseline::cubic:
      return 3;
    case Baseline::point_with_drag:
      break;  // no polynomial
  }
  throw ArgumentError("a baseline of no known kind");
}

bool follows_end(Baseline baseline) {
  return baseline == Baseline::constant_velocity || baseline == Baseline::constant_acceleration;
}

void check_count(const char* what, Eigen::Index count, const Eigen::VectorXd& times) {
  if (count == times.size()) return;
  throw ArgumentError(
      fmt::format("a span of {} times has {} {}; as many were expected", times.size(), count, what));
}

void check_span(const SeenMotion& span) {
  check_count("positions", span.positions.rows(), span.times);
  if (span.rates.size() == 0) return;
  check_count("rates", span.rates.rows(), span.times);
  if (span.rates.cols() == span.positions.cols()) return;
  throw ArgumentError(
      fmt::format("a motion has rates of {} components and positions of {}; as many were expected",
                  span.rates.cols(), span.positions.cols()));
}

void check_times(const Eigen::VectorXd& span, const Eigen::VectorXd& times) {
  if (!span.allFinite() || !times.allFinite())
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

/// A straight line through rates, and what it adds up to.
class RateLine {
 public:
  /// @param times finite, two or more
  RateLine(const Eigen::VectorXd& times, const Eigen::VectorXd& rates)
      : origin_(times[times.size() - 1]),
        length_(std::max(times.maxCoeff() - times.minCoeff(), std::numeric_limits<double>::min())),
        line_(powers(times, 1, origin_, length_).colPivHouseholderQr().solve(rates)) {}

  double rate(double time) const { return line_[0] + line_[1] * (time - origin_) / length_; }
  /// The integral from the last of the times on.
  double moved(double time) const {
    const double since = time - origin_;
    return since * (line_[0] + 0.5 * line_[1] * since / length_);
  }

 private:
  double origin_, length_;
  Eigen::VectorXd line_;
};

Eigen::VectorXd carry_on(const SeenMotion& span, Eigen::Index component, const Eigen::VectorXd& times) {
  std::vector<Eigen::Index> frames;
  for (Eigen::Index k = 0; k < span.rates.rows(); ++k) {
    if (std::isfinite(span.positions(k, component)) && std::isfinite(span.rates(k, component)))
      frames.push_back(k);
  }
  if (frames.size() < 2) return Eigen::VectorXd::Constant(times.size(), kNaN);
  const Eigen::VectorXd seen = span.times(frames);
  const RateLine line(seen, span.rates(frames, component));
  const auto moved = [&](double time) { return line.moved(time); };
  const Eigen::VectorXd positions = span.positions(frames, component);
  const double end = (positions - seen.unaryExpr(moved)).mean();
  return end + times.unaryExpr(moved).array();
}

Eigen::VectorXd predict_component(Baseline baseline, const Eigen::VectorXd& seen_times,
                                  const Eigen::VectorXd& component, const Eigen::VectorXd& times) {
  const int degree = degree_of(baseline);
  const std::vector<Eigen::Index> frames = seen_frames(component, follows_end(baseline));
  if (static_cast<int>(frames.size()) <= degree) return Eigen::VectorXd::Constant(times.size(), kNaN);
  const Eigen::VectorXd t = seen_times(frames);
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
    case Baseline::measured_velocity:
      return "measured velocity";
    case Baseline::point_with_drag:
      return "point with drag";
  }
  throw ArgumentError("a baseline of no known kind");
}

const std::vector<Baseline>& all_baselines() {
  static const std::vector<Baseline> all = {Baseline::straight_line,
                                            Baseline::quadratic,
                                            Baseline::cubic,
                                            Baseline::constant_velocity,
                                            Baseline::constant_acceleration,
                                            Baseline::measured_velocity,
                                            Baseline::point_with_drag};
  return all;
}

Eigen::MatrixXd predict(Baseline baseline, const SeenMotion& span, const Eigen::VectorXd& times) {
  check_span(span);
  check_times(span.times, times);
  if (baseline == Baseline::point_with_drag) return predict_point_with_drag(span, times);
  Eigen::MatrixXd result(times.size(), span.positions.cols());
  for (Eigen::Index c = 0; c < result.cols(); ++c) {
    result.col(c) = baseline == Baseline::measured_velocity
                        ? carry_on(span, c, times)
                        : predict_component(baseline, span.times, span.positions.col(c), times);
  }
  return result;
}

namespace {

/// Of the weights that make functional . polynomial of values, the polynomial by least squares.
double norm_of_weights(const Eigen::MatrixXd& design, const Eigen::VectorXd& functional) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(design);
  const Eigen::VectorXd permuted = qr.colsPermutation().transpose() * functional;
  return qr.matrixR()
      .topRows(design.cols())
      .triangularView<Eigen::Upper>()
      .transpose()
      .solve(permuted)
      .norm();
}

double gain_of_component(Baseline baseline, const SeenMotion& span, Eigen::Index component, double time) {
  const bool by_rates = baseline == Baseline::measured_velocity;
  const bool is_point = baseline == Baseline::point_with_drag;
  const int degree = is_point ? degree_of(Baseline::quadratic) : degree_of(baseline);
  if (by_rates && span.rates.size() == 0) return kNaN;
  // A point takes frames that show all components, four or more (point_with_drag.h).
  Eigen::VectorXd values = span.positions.col(component);
  if (is_point) values = span.positions.rowwise().sum();
  if (by_rates) values += span.rates.col(component);
  const std::vector<Eigen::Index> frames = seen_frames(values, follows_end(baseline));
  if (std::ssize(frames) <= (is_point ? degree + 1 : degree)) return kNaN;
  const Eigen::VectorXd t = span.times(frames);
  const double origin = t[t.size() - 1];
  const double length = std::max(t.maxCoeff() - t.minCoeff(), std::numeric_limits<double>::min());
  const Eigen::VectorXd at = Eigen::VectorXd::Constant(1, time);
  const Eigen::MatrixXd design = powers(t, degree, origin, length);
  if (!by_rates) return norm_of_weights(design, powers(at, degree, origin, length).row(0).transpose());
  // Of the integral of the line, less its mean over the frames (RateLine).
  const auto integral = [&](double until) {
    const double since = until - origin;
    return Eigen::Vector2d(since, 0.5 * since * since / length);
  };
  Eigen::Vector2d functional = integral(time);
  for (const double one : t) functional -= integral(one) / static_cast<double>(t.size());
  return norm_of_weights(design, functional);
}

}  // namespace

double noise_gain(Baseline baseline, const SeenMotion& span, double time) {
  check_span(span);
  check_times(span.times, Eigen::VectorXd::Constant(1, time));
  if (baseline == Baseline::point_with_drag && span.up < 0) return kNaN;
  double largest = kNaN;
  for (Eigen::Index c = 0; c < span.positions.cols(); ++c) {
    const double gain = gain_of_component(baseline, span, c, time);
    if (std::isnan(gain)) return kNaN;
    largest = std::isnan(largest) ? gain : std::max(largest, gain);
  }
  return largest;
}

namespace {

/// With the rates of a straight line, by steps of a rotation each.
Eigen::MatrixX4d turn_on(const SeenTurn& span, Eigen::Index last, const Eigen::VectorXd& times) {
  constexpr int kSteps = 50;  // from one time to the next
  Eigen::MatrixX4d result = Eigen::MatrixX4d::Constant(times.size(), 4, kNaN);
  std::vector<Eigen::Index> frames;
  for (Eigen::Index k = 0; k < span.body_rates.rows(); ++k) {
    if (span.body_rates.row(k).allFinite()) frames.push_back(k);
  }
  if (frames.size() < 2) return result;
  const Eigen::VectorXd seen = span.times(frames);
  std::vector<RateLine> lines;
  for (Eigen::Index axis = 0; axis < 3; ++axis) lines.emplace_back(seen, span.body_rates(frames, axis));
  Attitude q = attitude_of(span.attitudes.row(last).transpose()).normalized();
  double now = span.times[last];
  for (Eigen::Index row = 0; row < times.size(); ++row) {
    const double step = (times[row] - now) / kSteps;
    for (int k = 0; k < kSteps; ++k) {
      const double middle = now + (k + 0.5) * step;
      q = turned(q,
                 step * Eigen::Vector3d(lines[0].rate(middle), lines[1].rate(middle), lines[2].rate(middle)));
    }
    now = times[row];
    result.row(row) = components(q);
  }
  return result;
}

}  // namespace

Eigen::MatrixX4d predict_turn(Baseline baseline, const SeenTurn& span, const Eigen::VectorXd& times) {
  check_count("attitudes", span.attitudes.rows(), span.times);
  if (span.body_rates.size() > 0) check_count("rates", span.body_rates.rows(), span.times);
  check_times(span.times, times);
  Eigen::Index last = span.times.size();
  while (last-- > 0 && !span.attitudes.row(last).allFinite()) {
  }
  if (last < 0) return Eigen::MatrixX4d::Constant(times.size(), 4, kNaN);
  if (baseline == Baseline::measured_velocity) return turn_on(span, last, times);

  const Eigen::MatrixX4d seen = continuous_attitudes(span.times, span.attitudes);
  const Attitude reference = attitude_of(seen.row(last).transpose());
  Eigen::MatrixXd turns = Eigen::MatrixXd::Constant(seen.rows(), 3, kNaN);
  for (Eigen::Index k = 0; k < seen.rows(); ++k) {
    if (seen.row(k).allFinite())
      turns.row(k) = rotation_vector(reference, attitude_of(seen.row(k).transpose())).transpose();
  }
  const Eigen::MatrixXd ahead = predict(baseline, SeenMotion{span.times, turns}, times);
  Eigen::MatrixX4d result = Eigen::MatrixX4d::Constant(times.size(), 4, kNaN);
  for (Eigen::Index row = 0; row < times.size(); ++row) {
    if (ahead.row(row).allFinite())
      result.row(row) = components(turned(reference, ahead.row(row).transpose()));
  }
  return result;
}

std::vector<double> turn_distances(const Eigen::MatrixX4d& predicted, const Eigen::MatrixX4d& measured) {
  if (predicted.rows() != measured.rows()) {
    throw ArgumentError(fmt::format("a prediction of {} attitudes was compared with {} measured ones",
                                    predicted.rows(), measured.rows()));
  }
  std::vector<double> distances;
  for (Eigen::Index row = 0; row < predicted.rows(); ++row) {
    if (!predicted.row(row).allFinite() || !measured.row(row).allFinite()) continue;
    const Attitude a = attitude_of(predicted.row(row).transpose()).normalized();
    distances.push_back(a.angularDistance(attitude_of(measured.row(row).transpose()).normalized()));
  }
  return distances;
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

void PredictionTally::add(const std::vector<double>& distances, int cluster) {
  const int call = ++calls_so_far_;
  if (distances.empty()) return;
  ++score_.captures;
  distances_.insert(distances_.end(), distances.begin(), distances.end());
  clusters_.insert(clusters_.end(), distances.size(), cluster < 0 ? -call : cluster);
  calls_.insert(calls_.end(), distances.size(), call);
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
  if (proper_.count() == 0) return score;
  score.crps = proper_.mean_crps();
  score.coverage50 = proper_.coverage(0.5);
  score.coverage90 = proper_.coverage(0.9);
  score.coverage90_error = proper_.coverage_error(0.9);
  return score;
}

PredictionTally PredictionTally::shared_with(const PredictionTally& other) const {
  std::map<int, int> surplus;  // by call
  for (const int call : calls_) ++surplus[call];
  for (const int call : other.calls_) --surplus[call];
  PredictionTally shared(score_.predictor, score_.quantity, score_.unit);
  for (std::size_t k = 0; k < distances_.size(); ++k) {
    if (surplus.at(calls_[k]) != 0) continue;
    shared.distances_.push_back(distances_[k]);
    shared.clusters_.push_back(clusters_[k]);
  }
  return shared;
}

std::vector<double> PredictionTally::drawn(const std::vector<int>& clusters) const {
  std::vector<double> distances;
  for (const int cluster : clusters) {
    for (std::size_t k = 0; k < distances_.size(); ++k) {
      if (clusters_[k] == cluster) distances.push_back(distances_[k]);
    }
  }
  return distances;
}

PredictionTally::Difference PredictionTally::behind(const PredictionTally& other) const {
  const PredictionTally ours = shared_with(other), theirs = other.shared_with(*this);
  if (ours.distances_.empty()) return {kNaN, kNaN};
  Difference difference{median(ours.distances_) - median(theirs.distances_), kNaN};
  std::vector<int> clusters = ours.clusters_;
  std::ranges::sort(clusters);
  clusters.erase(std::unique(clusters.begin(), clusters.end()), clusters.end());
  if (clusters.size() < 2) return difference;
  constexpr int kDraws = 200;  // they tell an error to 5 %
  constexpr std::uint64_t kSeed = 28;
  double sum = 0.0, squares = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Stream stream(kSeed, static_cast<std::uint64_t>(draw));
    std::vector<int> chosen(clusters.size());
    for (int& one : chosen)
      one = clusters[static_cast<std::size_t>(stream.uniform() * static_cast<double>(clusters.size()))];
    const double here = median(ours.drawn(chosen)) - median(theirs.drawn(chosen));
    sum += here;
    squares += here * here;
  }
  const double scatter = (squares - sum * sum / kDraws) / (kDraws - 1);
  difference.error = std::sqrt(std::max(0.0, scatter));
  return difference;
}

}  // namespace samara::identification
