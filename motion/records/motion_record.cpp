#include "samara/motion/records/motion_record.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/units.h"
#include "samara/identification/smoothing/continuous_angles.h"

namespace samara::motion {

namespace {

using identification::Capture;

/// The normal is the third column of the rotation matrix.
Eigen::Vector3d normal_of(double w, double x, double y, double z) {
  const double scale = 1.0 / (w * w + x * x + y * y + z * z);
  return scale * Eigen::Vector3d(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), w * w - x * x - y * y + z * z);
}

void require_rows(Eigen::Index rows, Eigen::Index frames, const char* what) {
  if (rows == frames) return;
  throw ArgumentError(
      fmt::format("the record has {} {} for {} times, expected one for each", rows, what, frames));
}

}  // namespace

void check(const MotionRecord& record) {
  const Eigen::Index frames = record.frame_count();
  if (frames < kFewestFrames)
    throw ArgumentError(fmt::format("the record has {} frames, expected at least {}", frames, kFewestFrames));
  require_rows(record.positions.rows(), frames, "positions");
  if (record.normals.rows() > 0) require_rows(record.normals.rows(), frames, "normals");
  if (record.angles.size() > 0) require_rows(record.angles.size(), frames, "angles");
  if (record.normals.rows() > 0 && record.angles.size() > 0)
    throw ArgumentError("the record has normals and angles, expected one of the two");
  for (Eigen::Index k = 0; k < frames; ++k) {
    if (!std::isfinite(record.times[k]) || (k > 0 && record.times[k] <= record.times[k - 1])) {
      throw ArgumentError(fmt::format(
          "the time of frame {} of the record is {}, expected times that increase", k, record.times[k]));
    }
    const bool attitude_is_finite = (record.normals.rows() == 0 || record.normals.row(k).allFinite()) &&
                                    (record.angles.size() == 0 || std::isfinite(record.angles[k]));
    if (!record.positions.row(k).allFinite() || !attitude_is_finite)
      throw ArgumentError(fmt::format("frame {} of the record is not finite, expected it left out", k));
    if (record.normals.rows() > 0 && std::abs(record.normals.row(k).norm() - 1.0) > 1e-3) {
      throw ArgumentError(fmt::format("the normal in frame {} of the record has the length {}, expected 1", k,
                                      record.normals.row(k).norm()));
    }
  }
  for (const double number :
       {record.length, record.position_noise.value_or(0.0), record.angle_noise.value_or(0.0)}) {
    if (!(number >= 0.0) || !std::isfinite(number)) {
      throw ArgumentError(
          fmt::format("length or noise of the record is {}, expected a number from 0 on", number));
    }
  }
}

MotionRecord part(const MotionRecord& record, Eigen::Index first, Eigen::Index count) {
  MotionRecord piece = record;
  piece.times = record.times.segment(first, count);
  piece.positions = record.positions.middleRows(first, count);
  if (record.normals.rows() > 0) piece.normals = record.normals.middleRows(first, count);
  if (record.angles.size() > 0) piece.angles = record.angles.segment(first, count);
  return piece;
}

namespace {

const identification::Channel& pose_channel(const Capture& capture, const std::string& quantity) {
  try {
    return capture.channel(quantity);
  } catch (const ArgumentError& error) {
    identification::refuse(capture.file, error.what());
  }
}

}  // namespace

const Eigen::VectorXd& pose_values(const Capture& capture, const std::string& quantity) {
  const identification::Channel& channel = pose_channel(capture, quantity);
  if (channel.unit == "px") {
    identification::refuse(capture.file,
                           fmt::format("capture \"{}\": {} is in pixels, expected a scale in its sidecar",
                                       capture.id, quantity));
  }
  const bool is_place = quantity == "x" || quantity == "y" || quantity == "z";
  if (!same_dimension(channel.unit, "1") && !(is_place && same_dimension(channel.unit, "m"))) {
    identification::refuse(capture.file,
                           fmt::format("capture \"{}\": {} is in {}, expected {}", capture.id, quantity,
                                       channel.unit, is_place ? "a length" : "an angle or a plain number"));
  }
  return channel.values;
}

MotionRecord record_of(const Capture& capture, double length) {
  const bool spatial = capture.has("z");
  Eigen::MatrixXd columns(capture.frame_count(), 3);
  columns.col(0) = pose_values(capture, "x");
  columns.col(1) = spatial ? pose_values(capture, "y") : Eigen::VectorXd::Zero(capture.frame_count());
  columns.col(2) = pose_values(capture, spatial ? "z" : "y");
  const bool has_normals = spatial && capture.has("qw");
  const bool has_angles = !spatial && capture.has("theta");
  Eigen::MatrixX4d attitudes;
  if (has_normals) {
    attitudes.resize(capture.frame_count(), 4);
    const std::array names = {"qw", "qx", "qy", "qz"};
    for (std::size_t k = 0; k < names.size(); ++k)
      attitudes.col(static_cast<Eigen::Index>(k)) = pose_values(capture, names[k]);
  }
  const Eigen::VectorXd theta = has_angles ? pose_values(capture, "theta") : Eigen::VectorXd();
  std::vector<Eigen::Index> seen;
  for (Eigen::Index k = 0; k < capture.frame_count(); ++k) {
    if (columns.row(k).allFinite() && (!has_normals || attitudes.row(k).allFinite()) &&
        (!has_angles || std::isfinite(theta[k])))
      seen.push_back(k);
  }
  MotionRecord record;
  record.times = capture.times(seen);
  record.positions = columns(seen, Eigen::all);
  record.length = length;
  record.left_out = capture.frame_count() - record.frame_count();
  if (record.frame_count() < kFewestFrames) {
    identification::refuse(capture.file,
                           fmt::format("capture \"{}\" has {} frames that were seen, expected at least {}",
                                       capture.id, record.frame_count(), kFewestFrames));
  }
  if (has_angles) {
    // The plate looks the same after half a turn.
    record.angles = identification::unwrapped(record.times, theta(seen), std::numbers::pi);
  }
  if (has_normals) {
    record.normals.resize(record.frame_count(), 3);
    for (Eigen::Index k = 0; k < record.frame_count(); ++k) {
      const Eigen::Vector4d q = attitudes.row(seen[static_cast<std::size_t>(k)]);
      record.normals.row(k) = normal_of(q[0], q[1], q[2], q[3]);
      if (k > 0 && record.normals.row(k).dot(record.normals.row(k - 1)) < 0.0) record.normals.row(k) *= -1.0;
    }
  }
  return record;
}

MotionStates::MotionStates(const models::ModelInfo& info) {
  const auto layout = StateLayout::of(info);
  if (!layout) {
    throw ArgumentError(fmt::format(
        "model \"{}\" has no states x, y, z, qw, .. of a body in space, nor x, y, theta of one in a "
        "plane: its motions have no patterns",
        info.name));
  }
  layout_ = *layout;
}

Eigen::Vector3d MotionStates::normal(std::span<const double> state) const {
  if (is_planar()) return {-std::sin(angle(state)), 0.0, std::cos(angle(state))};
  const auto& q = layout_.attitude;
  return normal_of(state[q[0]], state[q[1]], state[q[2]], state[q[3]]);
}

double MotionStates::angle(std::span<const double> state) const {
  return state[layout_.attitude[0]];
}

double MotionStates::body_length(const models::Model& model, std::span<const double> parameters) {
  double semi = 0.0;
  const models::ModelInfo& info = model.info();
  for (std::size_t j = 0; j < info.parameters.size(); ++j) {
    const std::string& name = info.parameters[j].name;
    if (info.parameters[j].unit != "m") continue;
    if (name == "a" || name == "b" || name == "c" || name == "semi_chord")
      semi = std::max(semi, parameters[j]);
    if (name == "chord" || name == "length" || name == "diameter") semi = std::max(semi, 0.5 * parameters[j]);
  }
  // All lengths of a plate without units are in semi-chords.
  if (models::time_unit(info) == "1" && MotionStates(info).is_planar()) return 2.0;
  if (semi > 0.0) return 2.0 * semi;
  // A disc of that area, where nothing else is said.
  const auto area = std::ranges::find(info.parameters, "area", &models::ParameterInfo::name);
  if (area == info.parameters.end()) return 0.0;
  return 2.0 *
         std::sqrt(parameters[static_cast<std::size_t>(area - info.parameters.begin())] / std::numbers::pi);
}

RecordBuilder::RecordBuilder(const MotionStates& states, std::size_t frames) : states_(states) {
  times_.reserve(frames);
  numbers_.reserve(frames * (states.is_planar() ? 3 : 6));
}

void RecordBuilder::add(double t, std::span<const double> state) {
  times_.push_back(t);
  const Eigen::Vector3d place = states_.position(state);
  if (states_.is_planar()) {
    numbers_.insert(numbers_.end(), {place.x(), place.z(), states_.angle(state)});
    return;
  }
  const Eigen::Vector3d normal = states_.normal(state);
  numbers_.insert(numbers_.end(), place.begin(), place.end());
  numbers_.insert(numbers_.end(), normal.begin(), normal.end());
}

MotionRecord RecordBuilder::record(double length) const {
  const auto frames = static_cast<Eigen::Index>(times_.size());
  MotionRecord record;
  record.length = length;
  record.position_noise = record.angle_noise = 0.0;
  record.times = Eigen::Map<const Eigen::VectorXd>(times_.data(), frames);
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const Rows> numbers(numbers_.data(), frames, states_.is_planar() ? 3 : 6);
  record.positions.setZero(frames, 3);
  if (states_.is_planar()) {
    record.positions.col(0) = numbers.col(0);
    record.positions.col(2) = numbers.col(1);
    record.angles = numbers.col(2);
  } else {
    record.positions = numbers.leftCols<3>();
    record.normals = numbers.rightCols<3>();
  }
  return record;
}

}  // namespace samara::motion
