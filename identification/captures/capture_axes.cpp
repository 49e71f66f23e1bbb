#include "samara/identification/captures/capture_axes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/captures/capture_cleaning.h"
#include "samara/identification/smoothing/continuous_angles.h"
#include "samara/identification/smoothing/rotation_vectors.h"
#include "samara/identification/smoothing/smoothing.h"

namespace samara::identification {

namespace {

using Eigen::Index;

Channel& channel_of(Capture& capture, const std::string& quantity) {
  return *std::ranges::find(capture.channels, quantity, &Channel::quantity);
}

/// Whether all of some quantities are measured. @throws ArgumentError if only some are
bool has_all(const Capture& capture, const std::vector<std::string>& quantities) {
  const auto known = std::ranges::count_if(quantities, [&](const std::string& q) { return capture.has(q); });
  if (known == 0) return false;
  if (known == static_cast<std::ptrdiff_t>(quantities.size())) return true;
  throw ArgumentError(
      fmt::format("capture \"{}\" measures some of {}; all or none were expected to turn them", capture.id,
                  fmt::join(quantities, ", ")));
}

Eigen::Vector3d axis_of(char name) {
  return Eigen::Vector3d::Unit(name - 'x');
}

void store_quaternions(Capture& capture, const Eigen::MatrixX4d& quaternions) {
  for (Index k = 0; k < 4; ++k)
    channel_of(capture, kQuaternionChannels[static_cast<std::size_t>(k)]).values = quaternions.col(k);
}

}  // namespace

void angles_to_quaternion(Capture& capture, const std::vector<std::string>& angles,
                          const std::string& order) {
  if (capture.has(kQuaternionChannels[0]))
    throw ArgumentError(fmt::format("capture \"{}\" has a quaternion already", capture.id));
  Eigen::MatrixX4d quaternions(capture.times.size(), 4);
  for (Index i = 0; i < capture.times.size(); ++i) {
    Attitude attitude = Attitude::Identity();
    bool seen = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const double angle = capture.channel(angles[k]).values[i];
      seen = seen && !std::isnan(angle);
      attitude = attitude * Eigen::AngleAxisd(angle, axis_of(order[k]));
    }
    quaternions.row(i) = seen ? components(attitude.normalized())
                              : Eigen::RowVector4d::Constant(std::numeric_limits<double>::quiet_NaN());
  }
  std::erase_if(capture.channels,
                [&](const Channel& channel) { return std::ranges::count(angles, channel.quantity) > 0; });
  for (const std::string& quantity : kQuaternionChannels) capture.channels.push_back({quantity, "1", {}});
  store_quaternions(capture, continuous_attitudes(capture.times, quaternions));
}

void flip_quantities(Capture& capture, const std::vector<std::string>& quantities) {
  std::vector<std::string> all = quantities;
  for (const std::string& quantity : quantities) {
    if (!capture.has(quantity)) {
      std::vector<std::string> known;
      for (const Channel& channel : capture.channels) known.push_back(channel.quantity);
      throw ArgumentError(fmt::format("capture \"{}\" has no quantity \"{}\"{}", capture.id, quantity,
                                      suggestion(quantity, known)));
    }
    const bool is_place = quantity == "x" || quantity == "y" || quantity == "z";
    if (is_place && capture.has(kQuaternionChannels[0])) {
      throw ArgumentError(fmt::format(
          "capture \"{}\" has an attitude, which no mirrored world has; `up`, which turns the world, was "
          "expected in place of \"{}\"",
          capture.id, quantity));
    }
    const std::string velocity = "v" + quantity;
    if (is_place && capture.has(velocity) && std::ranges::count(all, velocity) == 0) all.push_back(velocity);
  }
  for (const std::string& quantity : all) {
    Channel& channel = channel_of(capture, quantity);
    channel.values = -channel.values;
    channel.is_flipped = !channel.is_flipped;
    if (channel.metres_per_pixel) channel.metres_per_pixel = -*channel.metres_per_pixel;
  }
}

void turn_upright(Capture& capture, const std::string& up) {
  if (up == "z") return;
  capture.up = up;
  const Eigen::Vector3d axis = (up[0] == '-' ? -1.0 : 1.0) * axis_of(up.back());
  // Opposite vectors have no shortest rotation: half a turn about x, which keeps the forward direction.
  const Attitude turn =
      up == "-z" ? Attitude(0.0, 1.0, 0.0, 0.0) : Attitude::FromTwoVectors(axis, Eigen::Vector3d::UnitZ());
  for (const std::vector<std::string>& vector :
       {std::vector<std::string>{"x", "y", "z"}, std::vector<std::string>{"vx", "vy", "vz"}}) {
    if (!has_all(capture, vector)) continue;
    const Eigen::Matrix3d rotation = turn.toRotationMatrix().array().round();
    Eigen::MatrixX3d values(capture.times.size(), 3);
    for (Index k = 0; k < 3; ++k) values.col(k) = capture.channel(vector[static_cast<std::size_t>(k)]).values;
    for (Index k = 0; k < 3; ++k) {
      // Only one component counts: a missing one of the others must not spread.
      Index source = 0;
      rotation.row(k).cwiseAbs().maxCoeff(&source);
      channel_of(capture, vector[static_cast<std::size_t>(k)]).values =
          rotation(k, source) * values.col(source);
    }
  }
  if (!has_all(capture, kQuaternionChannels)) return;
  Eigen::MatrixX4d quaternions(capture.times.size(), 4);
  for (Index k = 0; k < 4; ++k)
    quaternions.col(k) = capture.channel(kQuaternionChannels[static_cast<std::size_t>(k)]).values;
  for (Index i = 0; i < quaternions.rows(); ++i)
    quaternions.row(i) = components(turn * attitude_of(quaternions.row(i)));
  store_quaternions(capture, quaternions);
}

}  // namespace samara::identification
