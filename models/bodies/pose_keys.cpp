#include "samara/models/bodies/pose_keys.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"

namespace samara::models {

namespace {

constexpr std::array kShares = {0.25, 0.5, 0.75};
/// Of the whole: single precision, in which animations hold their times, tells no shorter intervals apart.
constexpr double kShortest = 1e-6;

/// Whether a pose lies within the limits of the share of the way from a to b.
bool is_between(const BodyPose& a, const BodyPose& b, double share, const BodyPose& pose,
                const PoseKeyLimits& limits) {
  if ((a.p_WB + share * (b.p_WB - a.p_WB) - pose.p_WB).norm() > limits.distance) return false;
  const double cosine = a.q_WB.dot(b.q_WB);
  const double sign = cosine < 0.0 ? -1.0 : 1.0;
  const double half = std::acos(std::min(1.0, std::abs(cosine)));
  if (2.0 * half > limits.turn) return false;
  Eigen::Vector4d between = (1.0 - share) * a.q_WB + share * sign * b.q_WB;
  if (half > 1e-6)
    between =
        (std::sin((1.0 - share) * half) * a.q_WB + std::sin(share * half) * sign * b.q_WB) / std::sin(half);
  return 2.0 * std::acos(std::min(1.0, std::abs(between.normalized().dot(pose.q_WB)))) <= limits.angle;
}

void check_limits(const PoseKeyLimits& limits) {
  constexpr const char* kWhere = "the limits of keys";
  require(limits.angle > 0.0, "angle [rad]", limits.angle, "more than 0", kWhere);
  require(limits.distance > 0.0, "distance", limits.distance, "more than 0", kWhere);
  require(limits.turn > 0.0, "turn [rad]", limits.turn, "more than 0", kWhere);
}

}  // namespace

PoseKeys dense_pose_keys(const std::function<std::vector<BodyPose>(const std::vector<double>&)>& poses_at,
                         double from, double to, const PoseKeyLimits& limits) {
  if (!(from < to))
    throw ArgumentError(fmt::format("the motion goes from {} to {}, expected later", from, to));
  check_limits(limits);
  constexpr int kFirst = 64;
  PoseKeys keys;
  for (int i = 0; i <= kFirst; ++i) keys.times.push_back(i == kFirst ? to : from + (to - from) * i / kFirst);
  keys.poses = poses_at(keys.times);
  std::vector<char> is_open(kFirst, 1);
  while (std::ranges::count(is_open, 1) > 0 && std::ssize(keys.times) <= limits.most) {
    std::vector<double> asked;
    for (std::size_t i = 0; i < is_open.size(); ++i) {
      for (const double share : kShares)
        if (is_open[i] != 0) asked.push_back(keys.times[i] + share * (keys.times[i + 1] - keys.times[i]));
    }
    const std::vector<BodyPose> found = poses_at(asked);
    PoseKeys next{.times = {keys.times[0]}, .poses = {keys.poses[0]}};
    std::vector<char> next_open;
    std::size_t at = 0;
    for (std::size_t i = 0; i < is_open.size(); ++i) {
      bool is_near = true;
      if (is_open[i] != 0) {
        for (std::size_t k = 0; k < kShares.size(); ++k)
          is_near =
              is_near && is_between(keys.poses[i], keys.poses[i + 1], kShares[k], found[at + k], limits);
        // Over a jump no line is near, however short.
        is_near = is_near || keys.times[i + 1] - keys.times[i] < kShortest * (to - from);
        if (!is_near) {
          next.times.push_back(asked[at + 1]);
          next.poses.push_back(found[at + 1]);
          next_open.push_back(1);
        }
        at += kShares.size();
      }
      next_open.push_back(is_near ? 0 : 1);
      next.times.push_back(keys.times[i + 1]);
      next.poses.push_back(keys.poses[i + 1]);
    }
    keys = std::move(next);
    is_open = std::move(next_open);
  }
  keys.is_dense = std::ranges::count(is_open, 1) == 0;
  return keys;
}

PoseTrack::PoseTrack(const PoseKeyLimits& limits) : limits_(limits) {
  check_limits(limits);
  keys_.is_dense = true;
}

bool PoseTrack::covers_waiting(double t, const BodyPose& pose) const {
  const double from = keys_.times.back();
  for (std::size_t k = 0; k < waiting_.times.size(); ++k) {
    const double share = (waiting_.times[k] - from) / (t - from);
    if (!is_between(keys_.poses.back(), pose, share, waiting_.poses[k], limits_)) return false;
  }
  return true;
}

void PoseTrack::add(double t, const BodyPose& pose) {
  const auto keep = [&](double at, const BodyPose& key) {
    keys_.times.push_back(at);
    keys_.poses.push_back(key);
  };
  if (seen_++ == 0) return keep(t, pose);
  const double before = waiting_.times.empty() ? keys_.times.back() : waiting_.times.back();
  if (!(t > before))
    throw ArgumentError(fmt::format("a pose at {} came after one at {}, expected later", t, before));
  if (!waiting_.times.empty() && !covers_waiting(t, pose)) {
    keep(waiting_.times.back(), waiting_.poses.back());
    waiting_ = {};
  }
  if (waiting_.times.empty() && !is_between(keys_.poses.back(), pose, 1.0, pose, limits_))
    keys_.is_dense = false;
  waiting_.times.push_back(t);
  waiting_.poses.push_back(pose);
}

PoseKeys PoseTrack::keys() const {
  PoseKeys all = keys_;
  if (waiting_.times.empty()) return all;
  all.times.push_back(waiting_.times.back());
  all.poses.push_back(waiting_.poses.back());
  return all;
}

}  // namespace samara::models
