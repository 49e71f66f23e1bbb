#pragma once

#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "samara/base/streams.h"
#include "samara/models/batch/batch.h"
#include "samara/models/laws/registry.h"
#include "samara/motion/records/motion_record.h"

/// Motions whose pattern is known: plates of the model sheet, a card, and drawn paths.

using Values = std::map<std::string, double>;

inline std::vector<double> equal_times(double until, double frame) {
  std::vector<double> times;
  for (int k = 0; k * frame <= until * (1.0 + 1e-12); ++k) times.push_back(k * frame);
  return times;
}

/// One trajectory of a model as a record, without noise.
inline samara::motion::MotionRecord simulated(const std::string& name, const Values& fixed, double until,
                                              double frame, double step) {
  const samara::models::ParametricModel model(samara::models::find_model(name), fixed, {});
  const samara::motion::MotionStates states(model.model().info());
  const std::vector<double> times = equal_times(until, frame);
  const auto batch = samara::models::integrate_batch(model, Eigen::MatrixXd(1, 0), times, {.step = step});
  samara::motion::RecordBuilder builder(states, times.size());
  for (Eigen::Index k = 0; k < batch.times.size(); ++k) {
    const Eigen::VectorXd state = batch.states.col(batch.column(0, k));
    builder.add(batch.times[k], {state.data(), static_cast<std::size_t>(state.size())});
  }
  return builder.record(samara::motion::MotionStates::body_length(model.model(), model.parameters({})));
}

/// The thin plate of the model sheet, section 3: by default until 120 a/U.
inline samara::motion::MotionRecord plate(const Values& fixed, double until = 120.0, double frame = 0.25) {
  Values all = fixed;
  all["beta"] = 0.0;
  return simulated("falling_plate_nd", all, until, frame, 0.02);
}

/// The card of dissertation Figure 5.6 in air, released 10 degrees about a horizontal axis `azimuth` from body x.
inline samara::motion::MotionRecord card(double C_D90, double C_T, double C_R, double azimuth, double until,
                                         double frame = 4e-3) {
  const double half = 5.0 * std::numbers::pi / 180.0;
  return simulated("immersed_body",
                   {{"a", 0.035},
                    {"b", 0.02},
                    {"c", 1e-4},
                    {"density", 1200.0},
                    {"C_D90", C_D90},
                    {"C_D0", 0.05},
                    {"C_T", C_T},
                    {"C_R", C_R},
                    {"C_w", 2.0},
                    {"qw(0)", std::cos(half)},
                    {"qx(0)", std::sin(half) * std::cos(azimuth)},
                    {"qy(0)", std::sin(half) * std::sin(azimuth)}},
                   until, frame, 1e-3);
}

/// Places and normals in the plane y = 0 as a record in space.
inline samara::motion::MotionRecord in_space(samara::motion::MotionRecord record) {
  if (record.is_planar()) {
    record.normals.setZero(record.frame_count(), 3);
    record.normals.col(0) = -record.angles.array().sin();
    record.normals.col(2) = record.angles.array().cos();
    record.angles.resize(0);
  }
  return record;
}

inline samara::motion::MotionRecord positions_only(samara::motion::MotionRecord record) {
  record.normals.resize(0, 3);
  record.angles.resize(0);
  return record;
}

inline samara::motion::MotionRecord turned(samara::motion::MotionRecord record, double yaw) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  record.positions = (record.positions * turn.transpose()).eval();
  if (record.normals.rows() > 0) record.normals = (record.normals * turn.transpose()).eval();
  return record;
}

/// In the plane x = 0; a motion in the plane y = 0 changes the sign of its angle.
inline samara::motion::MotionRecord mirrored(samara::motion::MotionRecord record) {
  record.positions.col(0) *= -1.0;
  if (record.normals.rows() > 0) record.normals.col(0) *= -1.0;
  record.angles *= -1.0;
  return record;
}

/// Noise of these deviations, drawn from stream 0 of the seed.
inline samara::motion::MotionRecord noisy(samara::motion::MotionRecord record, double position, double angle,
                                          std::uint64_t seed) {
  samara::Stream stream(seed, 0);
  for (Eigen::Index k = 0; k < record.frame_count(); ++k) {
    for (int c = 0; c < 3; ++c) record.positions(k, c) += position * stream.normal();
    if (record.angles.size() > 0) record.angles[k] += angle * stream.normal();
    if (record.normals.rows() == 0) continue;
    for (int c = 0; c < 3; ++c) record.normals(k, c) += angle * stream.normal();
    record.normals.row(k).normalize();
  }
  record.position_noise.reset();
  record.angle_noise.reset();
  return record;
}
