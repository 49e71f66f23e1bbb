#include "samara/identification/smoothing/continuous_angles.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/identification/smoothing/rotation_vectors.h"
#include "samara/identification/smoothing/smoothing_checks.h"

namespace samara::identification {

namespace {

using Eigen::Index;

/// So many rates give the median rate: two outliers among the frames spoil at most four of them, in turn.
constexpr std::size_t kRates = 5;
/// So many predecessors are carried forward: one outlier among them does not decide.
constexpr std::size_t kPredecessors = 3;

template <class Value>
void remember(std::deque<Value>& last, const Value& value, std::size_t count) {
  last.push_back(value);
  if (last.size() > count) last.pop_front();
}

/// The last frames of a coordinate or attitude that has been made continuous.
template <class Value>
struct Placed {
  double time;
  Value value;
};

double median_of(const std::deque<double>& values) {
  return median({values.begin(), values.end()});
}

Eigen::Vector3d median_of(const std::deque<Eigen::Vector3d>& values) {
  Eigen::Vector3d result = Eigen::Vector3d::Zero();
  for (Index axis = 0; axis < 3; ++axis) {
    std::vector<double> components;
    for (const Eigen::Vector3d& value : values) components.push_back(value[axis]);
    result[axis] = median(components);
  }
  return result;
}

/// The symmetry for which the attitude is nearest to where its predecessors lead: the median of its
/// distances from each of them, carried forward.
Attitude nearest_look(const Attitude& seen, double time, const std::deque<Placed<Attitude>>& placed,
                      const std::deque<Eigen::Vector3d>& rates, const std::vector<Attitude>& looks) {
  const Eigen::Vector3d rate = rates.empty() ? Eigen::Vector3d::Zero() : median_of(rates);
  std::vector<Attitude> predicted;
  for (const auto& [then, attitude] : placed) predicted.push_back(turned(attitude, rate * (time - then)));
  if (predicted.size() < kPredecessors) predicted.erase(predicted.begin(), predicted.end() - 1);
  const auto distance = [&](const Attitude& candidate) {
    std::vector<double> all;
    for (const Attitude& attitude : predicted) all.push_back(1.0 - std::abs(candidate.dot(attitude)));
    return median(all);
  };
  Attitude best = seen;
  for (const Attitude& look : looks) {
    if (distance(seen * look) < distance(best)) best = seen * look;
  }
  if (best.dot(predicted.back()) < 0.0) best.coeffs() *= -1.0;
  return best;
}

std::vector<Attitude> checked_looks(const BodySymmetries& symmetries) {
  std::vector<Attitude> looks;
  for (const Eigen::Vector4d& g : symmetries) {
    if (!g.allFinite() || std::abs(g.norm() - 1.0) > 1e-9) {
      throw ArgumentError(
          fmt::format("a symmetry of the body is ({}, {}, {}, {}); a unit quaternion was "
                      "expected",
                      g[0], g[1], g[2], g[3]));
    }
    looks.push_back(attitude_of(g));
  }
  return looks;
}

}  // namespace

Eigen::VectorXd unwrapped(const Eigen::VectorXd& times, const Eigen::VectorXd& angles, double period) {
  check_times(times, angles.size());
  if (!(period > 0.0 && std::isfinite(period)))
    throw ArgumentError(fmt::format("the period of an angle is {}; more than 0 was expected", period));
  std::deque<Placed<double>> placed;
  std::deque<double> rates;
  Eigen::VectorXd result = angles;
  for (Index i = 0; i < angles.size(); ++i) {
    if (std::isnan(angles[i])) continue;
    if (!placed.empty()) {
      const double rate = rates.empty() ? 0.0 : median_of(rates);
      std::vector<double> predicted;
      for (const auto& [then, angle] : placed) predicted.push_back(angle + rate * (times[i] - then));
      const double expected = predicted.size() < kPredecessors ? predicted.back() : median(predicted);
      result[i] += period * std::round((expected - angles[i]) / period);
      const auto& [then, angle] = placed.back();
      remember(rates, (result[i] - angle) / (times[i] - then), kRates);
    }
    remember(placed, {times[i], result[i]}, kPredecessors);
  }
  return result;
}

BodySymmetries half_turns() {
  return {{0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 1.0, 0.0}, {0.0, 0.0, 0.0, 1.0}};
}

Eigen::MatrixX4d continuous_attitudes(const Eigen::VectorXd& times, const Eigen::MatrixX4d& quaternions,
                                      const BodySymmetries& symmetries) {
  check_times(times, quaternions.rows());
  const std::vector<Attitude> looks = checked_looks(symmetries);
  std::deque<Placed<Attitude>> placed;
  std::deque<Eigen::Vector3d> rates;
  Eigen::MatrixX4d result = quaternions;
  for (Index i = 0; i < quaternions.rows(); ++i) {
    if (quaternions.row(i).array().isNaN().any()) {
      result.row(i).setConstant(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    const double length = quaternions.row(i).norm();
    if (!(length > 0.0 && std::isfinite(length)))
      throw ArgumentError(fmt::format("the quaternion of frame {} has length {}", i, length));
    Attitude attitude = attitude_of(quaternions.row(i) / length);
    if (!placed.empty()) {
      attitude = nearest_look(attitude, times[i], placed, rates, looks);
      const auto& [then, before] = placed.back();
      remember(rates, Eigen::Vector3d(rotation_vector(before, attitude) / (times[i] - then)), kRates);
    }
    remember(placed, {times[i], attitude}, kPredecessors);
    result.row(i) = components(attitude);
  }
  return result;
}

}  // namespace samara::identification
