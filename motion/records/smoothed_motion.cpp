#include "samara/motion/records/smoothed_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "samara/motion/records/even_frames.h"

namespace samara::motion {

namespace {

/// Weights of the frames around one: of the value and of the rate of a quadratic fitted to them.
struct QuadraticWeights {
  Eigen::VectorXd value, rate;
};

QuadraticWeights quadratic_weights(const Eigen::VectorXd& offsets) {
  const double span = offsets.cwiseAbs().maxCoeff();
  Eigen::MatrixX3d basis(offsets.size(), 3);
  basis << Eigen::VectorXd::Ones(offsets.size()), offsets / span, (offsets / span).cwiseAbs2();
  const Eigen::Matrix3d normal = basis.transpose() * basis;
  const Eigen::MatrixXd solution = normal.ldlt().solve(basis.transpose());
  return {solution.row(0), solution.row(1) / span};
}

struct Smooth {
  Eigen::MatrixXd values, rates;
  double value_share = 0.0;   ///< of the noise left in a value, median frame
  double rate_share = 0.0;    ///< of the noise left in a rate [1/s]
  Eigen::VectorXd residuals;  ///< per column, rms, over what noise of size 1 would leave
};

double middle_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Frames that lie like those of the frame before have the same weights.
Smooth smooth(const Eigen::VectorXd& times, const Eigen::MatrixXd& values, Eigen::Index half) {
  const Eigen::Index frames = times.size();
  const Eigen::Index width = 2 * half + 1;
  Smooth result;
  result.values.resize(frames, values.cols());
  result.rates.resize(frames, values.cols());
  result.residuals.setZero(values.cols());
  QuadraticWeights weights;
  Eigen::VectorXd offsets, last_offsets;
  std::vector<double> value_shares, rate_shares;
  double expected = 0.0;
  for (Eigen::Index k = 0; k < frames; ++k) {
    const Eigen::Index first = std::clamp<Eigen::Index>(k - half, 0, frames - width);
    offsets = times.segment(first, width).array() - times[k];
    if (last_offsets.size() != width ||
        (offsets - last_offsets).cwiseAbs().maxCoeff() > 1e-9 * (times[first + width - 1] - times[first])) {
      weights = quadratic_weights(offsets);
      last_offsets = offsets;
    }
    result.values.row(k).noalias() = weights.value.transpose() * values.middleRows(first, width);
    result.rates.row(k).noalias() = weights.rate.transpose() * values.middleRows(first, width);
    result.residuals += (result.values.row(k) - values.row(k)).transpose().cwiseAbs2();
    expected += 1.0 - 2.0 * weights.value[k - first] + weights.value.squaredNorm();
    value_shares.push_back(weights.value.norm());
    rate_shares.push_back(weights.rate.norm());
  }
  result.value_share = middle_of(std::move(value_shares));
  result.rate_share = middle_of(std::move(rate_shares));
  result.residuals = (result.residuals / expected).cwiseSqrt();
  return result;
}

/// Of the frames that were seen: those between are means of them, and have less.
double largest_noise(const Eigen::VectorXd& times, const Eigen::MatrixXd& columns) {
  double most = 0.0;
  for (Eigen::Index c = 0; c < columns.cols(); ++c) most = std::max(most, noise_of(columns.col(c), times));
  return most;
}

/// Mean, of the way over a few dozen pieces: over frames it would be that of the noise.
double mean_speed(const MotionRecord& record) {
  double way = 0.0;
  const Eigen::Index stride = std::max<Eigen::Index>(1, record.frame_count() / 24);
  for (Eigen::Index k = stride; k < record.frame_count(); k += stride)
    way += (record.positions.row(k) - record.positions.row(k - stride)).norm();
  return way / (record.times[record.frame_count() - 1] - record.times[0]);
}

/// Residuals of the narrowest quadratics are noise; where those of wider ones grow, motion is in them.
bool follows(const Smooth& at, const Smooth& narrowest) {
  constexpr double kMostGrowth = 1.08;
  return (at.residuals.array() <= kMostGrowth * narrowest.residuals.array()).all();
}

/// @param is_quiet whether little enough noise is left
template <class Predicate>
Smooth quietest(const Eigen::VectorXd& times, const Eigen::MatrixXd& values, const Predicate& is_quiet) {
  const Smooth narrowest = smooth(times, values, 2);
  Smooth best = narrowest;
  for (const Eigen::Index half : {3, 4, 5, 7, 9, 12, 16, 22, 30}) {
    if (is_quiet(best) || 6 * half > times.size()) break;
    Smooth wider = smooth(times, values, half);
    if (!follows(wider, narrowest)) break;
    best = std::move(wider);
  }
  return best;
}

/// In the time of one frame, also where some between were not seen.
double largest_turn(const MotionRecord& record, const std::vector<BetweenFrames>& frames) {
  Eigen::VectorXd steps = Eigen::VectorXd::Zero(record.frame_count());
  for (const BetweenFrames& frame : frames) steps[frame.before] += 1.0;
  double most = 0.0;
  for (Eigen::Index k = 1; k < record.frame_count(); ++k) {
    const double turn =
        record.is_planar()
            ? std::abs(record.angles[k] - record.angles[k - 1])
            : std::acos(std::clamp(record.normals.row(k).dot(record.normals.row(k - 1)), -1.0, 1.0));
    most = std::max(most, turn / steps[k - 1]);
  }
  return most;
}

}  // namespace

SmoothedMotion smoothed(const MotionRecord& record) {
  check(record);
  // Smoothing asks the frames that were seen; what it finds is bridged, not their noise.
  const std::vector<BetweenFrames> frames = even_frames(record.times);
  SmoothedMotion motion;
  motion.times = between(record.times, frames);
  const double noise =
      record.position_noise ? *record.position_noise : largest_noise(record.times, record.positions);
  const double quiet = 0.02 * mean_speed(record);
  const Smooth path = quietest(record.times, record.positions,
                               [&](const Smooth& at) { return at.rate_share * noise <= quiet; });
  motion.positions = between(path.values, frames);
  motion.velocities = between(path.rates, frames);
  motion.position_noise = path.value_share * noise;
  motion.velocity_noise = path.rate_share * noise;
  if ((record.positions.col(1).array() == record.positions(0, 1)).all()) motion.ground_directions = 1;
  if (!record.has_attitude()) return motion;
  const Eigen::MatrixXd attitude =
      record.is_planar() ? Eigen::MatrixXd(record.angles) : Eigen::MatrixXd(record.normals);
  const double angle_noise = record.angle_noise ? *record.angle_noise : largest_noise(record.times, attitude);
  constexpr double kQuietAngle = 0.04;  // rad
  const Smooth turning = quietest(
      record.times, attitude, [&](const Smooth& at) { return at.value_share * angle_noise <= kQuietAngle; });
  motion.angle_noise = turning.value_share * angle_noise;
  motion.frame_angle = largest_turn(record, frames);
  if (record.is_planar()) {
    motion.angles = between(turning.values, frames).col(0);
  } else {
    motion.normals = between(turning.values, frames).rowwise().normalized();
  }
  return motion;
}

SmoothedMotion part(const SmoothedMotion& motion, Eigen::Index first, Eigen::Index count) {
  SmoothedMotion piece = motion;
  piece.times = motion.times.segment(first, count);
  piece.positions = motion.positions.middleRows(first, count);
  piece.velocities = motion.velocities.middleRows(first, count);
  if (motion.normals.rows() > 0) piece.normals = motion.normals.middleRows(first, count);
  if (motion.angles.size() > 0) piece.angles = motion.angles.segment(first, count);
  return piece;
}

}  // namespace samara::motion
