#include "samara/motion/ghost/pose_path.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/motion/records/even_frames.h"
#include "samara/motion/records/motion_record.h"
#include "samara/motion/records/state_layout.h"

namespace samara::motion {

namespace {

constexpr Eigen::Index kStencil = kFewestPoses;
using StencilMatrix = Eigen::Matrix<double, kStencil, 1>;

const std::array<const char*, 3> kPlanarPose = {"x", "y", "theta"};
const std::array<const char*, 7> kSpatialPose = {"x", "y", "z", "qw", "qx", "qy", "qz"};

/// Weights of the first and the second derivative at 0 of the polynomial through nodes (B. Fornberg, Generation of
/// finite difference formulas on arbitrarily spaced grids, Math. Comp. 51 (1988) 699-706).
struct DerivativeWeights {
  StencilMatrix first, second;
};

DerivativeWeights weights_at_zero(const StencilMatrix& nodes) {
  Eigen::Matrix<double, kStencil, 3> c = Eigen::Matrix<double, kStencil, 3>::Zero();
  c(0, 0) = 1.0;
  double c1 = 1.0;
  for (Eigen::Index i = 1; i < kStencil; ++i) {
    double c2 = 1.0;
    for (Eigen::Index j = 0; j < i; ++j) {
      const double c3 = nodes[i] - nodes[j];
      c2 *= c3;
      if (j + 1 == i) {
        for (Eigen::Index k = 2; k >= 1; --k) {
          c(i, k) = c1 * (static_cast<double>(k) * c(i - 1, k - 1) - nodes[i - 1] * c(i - 1, k)) / c2;
        }
        c(i, 0) = -c1 * nodes[i - 1] * c(i - 1, 0) / c2;
      }
      for (Eigen::Index k = 2; k >= 1; --k) {
        c(j, k) = (nodes[i] * c(j, k) - static_cast<double>(k) * c(j, k - 1)) / c3;
      }
      c(j, 0) = nodes[i] * c(j, 0) / c3;
    }
    c1 = c2;
  }
  return {c.col(1), c.col(2)};
}

Eigen::Quaterniond attitude(const PosePath& path, Eigen::Index frame) {
  return Eigen::Quaterniond(path.poses(frame, 3), path.poses(frame, 4), path.poses(frame, 5),
                            path.poses(frame, 6))
      .normalized();
}

/// The rotation vector of q, of the shorter way.
Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d axis = sign * q.vec();
  const double sine = axis.norm();
  if (sine < 1e-9) return 2.0 * axis;
  return 2.0 * std::atan2(sine, sign * q.w()) / sine * axis;
}

/// A simulation keeps the length that it began with.
void check_quaternions(const Eigen::Ref<const Eigen::MatrixX4d>& quaternions) {
  const Eigen::VectorXd lengths = quaternions.rowwise().norm();
  constexpr double kLeast = 1e-3, kMostChange = 1e-3;
  if (!(lengths[0] >= kLeast)) {
    throw ArgumentError(
        fmt::format("the quaternion in frame 0 of the path has the length {:.6g}, expected {} or more",
                    lengths[0], kLeast));
  }
  for (Eigen::Index k = 1; k < lengths.size(); ++k) {
    if (std::abs(lengths[k] / lengths[0] - 1.0) <= kMostChange) continue;
    throw ArgumentError(fmt::format(
        "the quaternion in frame {} of the path has the length {:.6g}, expected {:.6g} as in frame 0", k,
        lengths[k], lengths[0]));
  }
}

void check_path(const PosePath& path) {
  const Eigen::Index frames = path.times.size();
  if (frames < kStencil || path.poses.rows() != frames) {
    throw ArgumentError(
        fmt::format("the path has {} times and {} poses, expected one pose for each of {} times or more",
                    frames, path.poses.rows(), kStencil));
  }
  if (path.poses.cols() != 3 && path.poses.cols() != 7) {
    throw ArgumentError(fmt::format("a pose of the path has {} numbers, expected 3 in a plane or 7 in space",
                                    path.poses.cols()));
  }
  for (Eigen::Index k = 0; k < frames; ++k) {
    if (!std::isfinite(path.times[k]) || !path.poses.row(k).allFinite())
      throw ArgumentError(fmt::format("frame {} of the path is not finite, expected numbers", k));
    if (k > 0 && !(path.times[k] > path.times[k - 1])) {
      throw ArgumentError(
          fmt::format("the time of frame {} of the path is {} after {}, expected times that increase", k,
                      path.times[k], path.times[k - 1]));
    }
  }
  if (!path.is_planar()) check_quaternions(path.poses.rightCols<4>());
}

void check_turn(double turn, Eigen::Index frame) {
  constexpr double kMostTurn = 2.0;
  if (std::abs(turn) <= kMostTurn) return;
  throw ArgumentError(
      fmt::format("the path turns by {:.2f} rad from frame {} to one within {} of it, expected at most {}: "
                  "more frames a second",
                  std::abs(turn), frame, kEndFrames, kMostTurn));
}

/// Body axes turn: what is fixed in the world has the rate -w x there.
void planar_rates(const PosePath& path, Eigen::Index frame, const DerivativeWeights& weights,
                  Eigen::Ref<Eigen::RowVectorXd> velocity, Eigen::Ref<Eigen::RowVectorXd> acceleration) {
  const auto around = path.poses.middleRows(frame - kEndFrames, kStencil);
  for (Eigen::Index j = 0; j < kStencil; ++j) check_turn(around(j, 2) - path.poses(frame, 2), frame);
  const Eigen::RowVector3d first = weights.first.transpose() * around;
  const Eigen::RowVector3d second = weights.second.transpose() * around;
  const double c = std::cos(path.poses(frame, 2)), s = std::sin(path.poses(frame, 2));
  const double w = first[2];
  const double vx = c * first[0] + s * first[1], vy = -s * first[0] + c * first[1];
  velocity << vx, vy, w;
  acceleration << c * second[0] + s * second[1] + w * vy, -s * second[0] + c * second[1] - w * vx, second[2];
}

/// Rotation vectors from the attitude of a frame to those of frames around it, in rows.
Eigen::MatrixX3d turns_around(const PosePath& path, Eigen::Index frame, Eigen::Index ends) {
  const Eigen::Quaterniond here = attitude(path, frame);
  Eigen::MatrixX3d turns(2 * ends + 1, 3);
  for (Eigen::Index j = 0; j < turns.rows(); ++j)
    turns.row(j) = rotation_vector(here.conjugate() * attitude(path, frame - ends + j));
  return turns;
}

/// Of rotation vectors phi from the attitude of a frame, w = phi' and w' = phi'' there: the terms that w has besides
/// vanish with phi, and their rate is phi' x phi'/2 = 0.
void spatial_rates(const PosePath& path, Eigen::Index frame, const DerivativeWeights& weights,
                   Eigen::Ref<Eigen::RowVectorXd> velocity, Eigen::Ref<Eigen::RowVectorXd> acceleration) {
  const Eigen::Quaterniond here = attitude(path, frame);
  const Eigen::Matrix<double, kStencil, 3> turns = turns_around(path, frame, kEndFrames);
  for (Eigen::Index j = 0; j < kStencil; ++j) check_turn(turns.row(j).norm(), frame);
  const auto places = path.poses.block(frame - kEndFrames, 0, kStencil, 3);
  const Eigen::Vector3d p1 = (weights.first.transpose() * places).transpose();
  const Eigen::Vector3d p2 = (weights.second.transpose() * places).transpose();
  const Eigen::Vector3d w = (weights.first.transpose() * turns).transpose();
  const Eigen::Vector3d u = here.conjugate() * p1;
  velocity << u.transpose(), w.transpose();
  acceleration << (here.conjugate() * p2 - w.cross(u)).transpose(), weights.second.transpose() * turns;
}

}  // namespace

PosePath path_of(const models::ModelInfo& model, const Eigen::VectorXd& times,
                 const Eigen::MatrixXd& states) {
  const auto layout = StateLayout::of(model);
  if (!layout)
    throw ArgumentError(fmt::format("model \"{}\" moves no body in a plane or in space", model.name));
  std::vector<Eigen::Index> columns;
  for (const auto& indices : {layout->positions(), layout->attitudes()})
    columns.insert(columns.end(), indices.begin(), indices.end());
  return {.times = times, .poses = states(Eigen::all, columns)};
}

PosePath path_of(const identification::Capture& capture) {
  const bool spatial = capture.has("z");
  PosePath path{.times = capture.times, .poses = Eigen::MatrixXd(capture.frame_count(), spatial ? 7 : 3)};
  for (Eigen::Index k = 0; k < path.poses.cols(); ++k) {
    const char* name =
        spatial ? kSpatialPose[static_cast<std::size_t>(k)] : kPlanarPose[static_cast<std::size_t>(k)];
    const Eigen::VectorXd& values = pose_values(capture, name);
    for (Eigen::Index frame = 0; frame < values.size(); ++frame) {
      if (std::isfinite(values[frame])) continue;
      identification::refuse(
          capture.file, fmt::format("{} was not seen in frame {} of \"{}\", expected it in all frames", name,
                                    frame, capture.id));
    }
    path.poses.col(k) = values;
  }
  return path;
}

PathNoise noise_of(const PosePath& path) {
  constexpr Eigen::Index kEnds = 4, kFrames = 2 * kEnds + 1;
  const Eigen::Index places = path.is_planar() ? 2 : 3, angles = path.is_planar() ? 1 : 3;
  const Eigen::Index count = std::max<Eigen::Index>(0, path.times.size() - kFrames + 1);
  Eigen::MatrixXd differences(count, places + angles), poses(kFrames, places + angles);
  for (Eigen::Index k = 0; k < count; ++k) {
    poses = path.poses.block(k, 0, kFrames, places + angles);
    if (!path.is_planar()) poses.rightCols<3>() = turns_around(path, k + kEnds, kEnds);  // for quaternions
    differences.row(k) = divided_difference(path.times.segment(k, kFrames)).transpose() * poses;
  }
  const auto rms = [](const auto& columns) {
    double sum = 0.0;
    for (const auto& column : columns.colwise()) sum += std::pow(deviation_of(column), 2);
    return std::sqrt(sum / static_cast<double>(columns.cols()));
  };
  return {.position = rms(differences.leftCols(places)), .angle = rms(differences.rightCols(angles))};
}

double mean_square_gain(const PosePath& path) {
  const Eigen::Index count = path.times.size() - 2 * kEndFrames;
  double sum = 0.0;
  for (Eigen::Index k = 0; k < count; ++k)
    sum += weights_at_zero(path.times.segment<kStencil>(k).array() - path.times[k + kEndFrames])
               .second.squaredNorm();
  return sum / static_cast<double>(count);
}

PathRates path_rates(const PosePath& path) {
  check_path(path);
  const Eigen::Index count = path.times.size() - 2 * kEndFrames;
  const Eigen::Index rates = path.is_planar() ? 3 : 6;
  PathRates result{Eigen::MatrixXd(count, rates), Eigen::MatrixXd(count, rates)};
  Eigen::RowVectorXd velocity(rates), acceleration(rates);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index frame = k + kEndFrames;
    const StencilMatrix nodes = path.times.segment<kStencil>(k).array() - path.times[frame];
    const DerivativeWeights weights = weights_at_zero(nodes);
    (path.is_planar() ? planar_rates : spatial_rates)(path, frame, weights, velocity, acceleration);
    result.velocities.row(k) = velocity;
    result.accelerations.row(k) = acceleration;
  }
  return result;
}

}  // namespace samara::motion
