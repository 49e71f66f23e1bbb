#include "samara/identification/smoothing/smoothing_attitude.h"

#include <algorithm>
#include <cmath>

#include "samara/identification/smoothing/continuous_angles.h"
#include "samara/identification/smoothing/local_polynomial.h"
#include "samara/identification/smoothing/rotation_vectors.h"
#include "samara/identification/smoothing/smoothing_checks.h"

namespace samara::identification {

namespace {

using Eigen::Index;
using SeenFrames = std::vector<Index>;

/// Attitudes are unit quaternions in double precision.
constexpr double kLeastNoise = 1e-14;

/// The seen frames.
struct SeenAttitudes {
  SeenFrames frame;
  LocalFrames frames;
  std::vector<Attitude> attitudes;

  /// Rotation vectors of some frames from a reference; rows.
  Eigen::MatrixXd from(const Attitude& reference, const SeenFrames& some) const {
    Eigen::MatrixXd rows(static_cast<Index>(some.size()), 3);
    for (Index k = 0; k < rows.rows(); ++k) {
      const auto i = static_cast<std::size_t>(some[static_cast<std::size_t>(k)]);
      rows.row(k) = rotation_vector(reference, attitudes[i]).transpose();
    }
    return rows;
  }
};

SeenAttitudes seen_attitudes(const Eigen::VectorXd& times, const Eigen::MatrixX4d& continuous,
                             const SmoothingOptions& options) {
  SeenAttitudes seen;
  for (Index i = 0; i < times.size(); ++i) {
    if (std::isnan(continuous(i, 0))) continue;
    seen.frame.push_back(i);
    seen.attitudes.push_back(attitude_of(continuous.row(i)));
  }
  seen.frames = seen_frames(times, seen.frame, options);
  return seen;
}

/// The polynomial of rotation vectors from its own value at t, and that value. There the rotation vector is
/// 0, so that its derivatives are the angular velocity and acceleration in body axes.
struct LocalAttitude {
  Attitude attitude;
  LocalPolynomial motion;
};

LocalAttitude attitude_at(const SeenAttitudes& seen, double t) {
  constexpr int kMostIterations = 20;
  const SeenFrames used = seen.frames.around(t);
  const Eigen::VectorXd equal = Eigen::VectorXd::Ones(static_cast<Index>(used.size()));
  const Index nearest =
      *std::ranges::min_element(used, {}, [&](Index i) { return std::abs(seen.frames.times[i] - t); });
  LocalAttitude local{seen.attitudes[static_cast<std::size_t>(nearest)], {}};
  for (int k = 0; k < kMostIterations; ++k) {
    local.motion = fit_local(seen.frames, used, t, equal, seen.from(local.attitude, used));
    const Eigen::Vector3d rest = local.motion.derivatives.row(0).transpose();
    local.attitude = turned(local.attitude, rest);
    if (rest.norm() < 1e-12) break;
  }
  return local;
}

}  // namespace

SmoothedAttitude smooth_attitude(const Eigen::VectorXd& times, const Eigen::MatrixX4d& quaternions,
                                 const Eigen::VectorXd& at, const SmoothingOptions& options,
                                 const BodySymmetries& symmetries) {
  check_smoothing(times, quaternions.rows(), at, options);
  SeenAttitudes seen = seen_attitudes(times, continuous_attitudes(times, quaternions, symmetries), options);
  check_seen_frames(seen.frames.count(), options);
  const auto chart = [&](Index reference, const SeenFrames& frames) {
    return seen.from(seen.attitudes[static_cast<std::size_t>(reference)], frames);
  };
  weigh_outliers(seen.frames, chart, 3, {options.outlier_threshold, options.noise, kLeastNoise});

  SmoothedAttitude result;
  result.outlier.setConstant(times.size(), false);
  for (std::size_t k = 0; k < seen.frame.size(); ++k)
    result.outlier[seen.frame[k]] = seen.frames.weights[static_cast<Index>(k)] == 0.0;
  result.noise = options.noise ? *options.noise : residual_noise(seen.frames, chart, 3);
  result.attitude.resize(at.size(), 4);
  for (Eigen::MatrixX3d* field :
       {&result.angular_velocity, &result.angular_acceleration, &result.attitude_error,
        &result.angular_velocity_error, &result.angular_acceleration_error}) {
    field->resize(at.size(), 3);
  }
  result.span.resize(at.size());
  for (Index row = 0; row < at.size(); ++row) {
    const LocalAttitude local = attitude_at(seen, at[row]);
    result.attitude.row(row) = components(local.attitude);
    result.angular_velocity.row(row) = local.motion.derivatives.row(1);
    result.angular_acceleration.row(row) = local.motion.derivatives.row(2);
    result.attitude_error.row(row).setConstant(result.noise * local.motion.deviations[0]);
    result.angular_velocity_error.row(row).setConstant(result.noise * local.motion.deviations[1]);
    result.angular_acceleration_error.row(row).setConstant(result.noise * local.motion.deviations[2]);
    result.span[row] = local.motion.span;
  }
  return result;
}

}  // namespace samara::identification
