#include "samara/motion/patterns/attitude_features.h"

#include <algorithm>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace samara::motion {

namespace {

constexpr double kPi = std::numbers::pi;

/// A half turn: where it ended, and the vector that the normal swept on it (rotation about it, rad).
struct HalfTurn {
  Eigen::Index frame = 0;
  Eigen::Vector3d swept = Eigen::Vector3d::Zero();
};

/// The side that faces down changes where theta leaves the half turn around it, and the margin.
std::vector<HalfTurn> half_turns_in_plane(const Eigen::VectorXd& angles, double margin) {
  std::vector<HalfTurn> turns;
  double side = std::round(angles[0] / kPi);
  for (Eigen::Index k = 0; k < angles.size(); ++k) {
    if (std::abs(angles[k] - side * kPi) <= 0.5 * kPi + margin) continue;
    const double next = std::round(angles[k] / kPi);
    turns.push_back({k, Eigen::Vector3d(0.0, kPi * (next - side), 0.0)});
    side = next;
  }
  return turns;
}

/// Integral of n x dn up to each frame.
Eigen::MatrixX3d swept_vectors(const Eigen::MatrixX3d& normals) {
  Eigen::MatrixX3d swept(normals.rows(), 3);
  swept.row(0).setZero();
  for (Eigen::Index k = 1; k < normals.rows(); ++k) {
    const Eigen::Vector3d a = normals.row(k - 1), b = normals.row(k);
    const Eigen::Vector3d axis = a.cross(b);
    const double sine = axis.norm();
    const double angle = std::atan2(sine, a.dot(b));
    swept.row(k) = swept.row(k - 1) + (sine > 1e-12 ? angle / sine : 1.0) * axis.transpose();
  }
  return swept;
}

std::vector<HalfTurn> half_turns_in_space(const Eigen::MatrixX3d& normals, const Eigen::MatrixX3d& swept,
                                          double margin) {
  std::vector<HalfTurn> turns;
  const double beyond = std::sin(margin);
  double side = normals(0, 2) < 0.0 ? -1.0 : 1.0;
  Eigen::Vector3d start = swept.row(0);
  for (Eigen::Index k = 0; k < normals.rows(); ++k) {
    if (normals(k, 2) * side >= -beyond) continue;
    side = -side;
    const Eigen::Vector3d here = swept.row(k);
    turns.push_back({k, here - start});
    start = here;
  }
  return turns;
}

/// +1: always the same way round.
double coherence_of(const std::vector<HalfTurn>& turns, Seen seen) {
  if (turns.empty()) return std::numeric_limits<double>::quiet_NaN();
  if (seen == Seen::plane) {
    double net = 0.0, total = 0.0;
    for (const HalfTurn& turn : turns) {
      net += turn.swept.y();
      total += turn.swept.norm();
    }
    return std::abs(net) / total;
  }
  // The first half turn began before the record did.
  if (turns.size() < 3) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for (std::size_t k = 2; k < turns.size(); ++k)
    sum += turns[k].swept.normalized().dot(turns[k - 1].swept.normalized());
  return sum / static_cast<double>(turns.size() - 2);
}

double tilt_of(const SmoothedMotion& settled, double noise) {
  std::vector<double> angles;
  if (settled.is_planar()) {
    angles.assign(settled.angles.begin(), settled.angles.end());
  } else {
    for (const double up : settled.normals.col(2)) angles.push_back(std::acos(std::min(1.0, std::abs(up))));
  }
  const double raw =
      settled.is_planar() ? quantile(angles, 0.95) - quantile(angles, 0.05) : quantile(angles, 0.95);
  return std::sqrt(std::max(0.0, raw * raw - noise * noise));
}

/// The angle walked about the axis about which most is walked.
Eigen::VectorXd main_angle(const Eigen::MatrixX3d& swept) {
  const Eigen::MatrixX3d steps = swept.bottomRows(swept.rows() - 1) - swept.topRows(swept.rows() - 1);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(steps.transpose() * steps);
  return swept * axes.eigenvectors().col(2);
}

/// Half turns, the angle walked, and the frames at which it turns back.
struct Turning {
  std::vector<HalfTurn> turns;
  Eigen::VectorXd angle;
  std::vector<Eigen::Index> back;
};

Turning turning_of(const SmoothedMotion& motion, const FeatureOptions& options) {
  Turning turning;
  if (motion.is_planar()) {
    turning.turns = half_turns_in_plane(motion.angles, options.flip_margin_plane);
    turning.angle = motion.angles;
  } else {
    const Eigen::MatrixX3d swept = swept_vectors(motion.normals);
    turning.turns = half_turns_in_space(motion.normals, swept, options.flip_margin_space);
    turning.angle = main_angle(swept);
  }
  turning.back = turning_points(turning.angle, std::max(options.swing_margin, 5.0 * motion.angle_noise));
  return turning;
}

/// Where the path is at every frame, and the variance of noise in all of it.
struct PhasePath {
  Eigen::MatrixXd places;
  double noise = 0.0;
};

PhasePath phase_path(const SmoothedMotion& settled, Eigen::Index stride) {
  PhasePath path;
  const Eigen::Index frames = (settled.frame_count() + stride - 1) / stride;
  if (settled.is_planar()) {
    path.places.resize(frames, 2);
    for (Eigen::Index k = 0; k < frames; ++k) {
      const double twice = 2.0 * settled.angles[k * stride];
      path.places.row(k) << std::cos(twice), std::sin(twice);
    }
    path.noise = 4.0 * settled.angle_noise * settled.angle_noise;
    return path;
  }
  const double speed = std::sqrt(settled.velocities.rowwise().squaredNorm().mean());
  const double share = settled.velocity_noise / speed;
  const bool has_normals = settled.normals.rows() > 0;
  path.places.resize(frames, has_normals ? 3 : 2);
  double slope = 0.0;  // of n_z^2, squared, mean
  for (Eigen::Index k = 0; k < frames; ++k) {
    const Eigen::RowVector3d v = settled.velocities.row(k * stride) / speed;
    path.places.row(k).head<2>() << v.z(), v.head<2>().norm();
    if (!has_normals) continue;
    const double up = settled.normals(k * stride, 2);
    path.places(k, 2) = up * up;
    slope += 4.0 * up * up * (1.0 - up * up) / static_cast<double>(frames);
  }
  path.noise = 2.0 * share * share + slope * settled.angle_noise * settled.angle_noise;
  return path;
}

/// Least value of a parabola through three points an interval apart, the middle one least.
double parabola_least(double before, double at, double after) {
  const double curvature = before - 2.0 * at + after;
  if (!(curvature > 0.0)) return at;
  const double slope = 0.5 * (after - before);
  return std::max(0.0, at - 0.5 * slope * slope / curvature);
}

}  // namespace

double quantile(std::vector<double> values, double p) {
  const double place = p * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(below);
  std::ranges::nth_element(values, at);
  if (below + 1 == values.size()) return *at;
  const double next = *std::min_element(at + 1, values.end());
  return *at + (place - static_cast<double>(below)) * (next - *at);
}

std::vector<Eigen::Index> turning_points(const Eigen::Ref<const Eigen::VectorXd>& values, double band) {
  std::vector<Eigen::Index> points;
  Eigen::Index lowest = 0, highest = 0;
  int way = 0;  // of the last confirmed move
  for (Eigen::Index k = 1; k < values.size(); ++k) {
    if (values[k] > values[highest]) highest = k;
    if (values[k] < values[lowest]) lowest = k;
    if (way >= 0 && values[highest] - values[k] > band) {
      if (way > 0) points.push_back(highest);
      way = -1;
      lowest = k;
    } else if (way <= 0 && values[k] - values[lowest] > band) {
      if (way < 0) points.push_back(lowest);
      way = 1;
      highest = k;
    }
  }
  return points;
}

std::vector<Eigen::Index> attitude_swings(const SmoothedMotion& motion, const FeatureOptions& options) {
  const Turning turning = turning_of(motion, options);
  std::vector<Eigen::Index> frames = turning.back;
  for (const HalfTurn& turn : turning.turns) frames.push_back(turn.frame);
  std::ranges::sort(frames);
  return frames;
}

void add_attitude_features(const SmoothedMotion& settled, const FeatureOptions& options, Features& features) {
  // 5 to 95 % range of a normal variate; 95 % point of the length of two of them.
  const double noise = (settled.is_planar() ? 3.29 : 2.45) * settled.angle_noise;
  features[Feature::tilt_noise] = noise;
  features[Feature::frame_angle] = settled.frame_angle;
  features[Feature::tilt] = tilt_of(settled, noise);
  const Turning turning = turning_of(settled, options);
  features[Feature::flips] = static_cast<double>(turning.turns.size());
  features[Feature::coherence] = coherence_of(turning.turns, features.seen);
  double walked = 0.0;
  Eigen::Index last = 0;
  for (const Eigen::Index k : turning.back) {
    walked += std::abs(turning.angle[k] - turning.angle[last]);
    last = k;
  }
  walked += std::abs(turning.angle[turning.angle.size() - 1] - turning.angle[last]);
  if (walked > 0.0) features[Feature::reversals] = static_cast<double>(turning.back.size()) / (walked / kPi);
  features[Feature::swings] = static_cast<double>(turning.back.size() + turning.turns.size());
}

double recurrence(const SmoothedMotion& settled, double swing_time) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  // Some 24 places a swing are enough: what is between them follows from the parabola.
  const double frame = (settled.times[settled.frame_count() - 1] - settled.times[0]) /
                       static_cast<double>(settled.frame_count() - 1);
  const auto stride = std::max<Eigen::Index>(1, static_cast<Eigen::Index>(swing_time / (24.0 * frame)));
  const PhasePath path = phase_path(settled, stride);
  const Eigen::Index count = path.places.rows();
  const Eigen::MatrixXd centred = path.places.rowwise() - path.places.colwise().mean();
  const double variance = centred.squaredNorm() / static_cast<double>(count) - path.noise;
  if (!(variance > 0.0)) return none;
  const auto lag_of_swings =
      static_cast<Eigen::Index>(24.0 * swing_time / (frame * static_cast<double>(stride)));
  const Eigen::Index last = std::min(count / 2, std::max<Eigen::Index>(4, lag_of_swings));
  double least = 1.0;
  bool has_left = false;
  double before = 0.0, at = 0.0;
  for (Eigen::Index lag = 1; lag <= last; ++lag) {
    const Eigen::Index pairs = count - lag;
    const double apart = (centred.bottomRows(pairs) - centred.topRows(pairs)).squaredNorm();
    const double here =
        std::max(0.0, apart / static_cast<double>(pairs) - 2.0 * path.noise) / (2.0 * variance);
    if (has_left && lag >= 3 && at <= before && at <= here)
      least = std::min(least, parabola_least(before, at, here));
    has_left = has_left || here > 0.49;
    before = at;
    at = here;
  }
  return has_left ? std::sqrt(std::min(1.0, least)) : none;
}

}  // namespace samara::motion
