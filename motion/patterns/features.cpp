#include "samara/motion/patterns/features.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"
#include "samara/motion/patterns/attitude_features.h"

namespace samara::motion {

namespace {

/// Of columns x and y about zero, the greatest first.
struct MainDirections {
  Eigen::Vector2d first;
  double first_variance = 0.0, second_variance = 0.0;
};

MainDirections main_directions(const Eigen::MatrixX2d& values) {
  const Eigen::MatrixXd square = values.transpose() * values / static_cast<double>(values.rows());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(square);
  return {axes.eigenvectors().col(1), axes.eigenvalues()[1], std::max(0.0, axes.eigenvalues()[0])};
}

/// Centre of the circle that is nearest to points in the sense of Kasa: |p - c|^2 - r^2 in the mean.
Eigen::Vector2d circle_centre(const Eigen::MatrixX2d& points) {
  Eigen::MatrixXd basis(points.rows(), 3);
  basis << points, Eigen::VectorXd::Ones(points.rows());
  const Eigen::VectorXd squares = points.rowwise().squaredNorm();
  const Eigen::VectorXd solution = basis.colPivHouseholderQr().solve(squares);
  return 0.5 * solution.head<2>();
}

/// The place about the centre of its revolution, which drifts: x = c + b t + A cos(phi) + B sin(phi), phi the angle
/// about c + b t. It begins at the centre of the circle that the velocity draws.
Eigen::MatrixX2d about_drifting_centre(const SmoothedMotion& settled) {
  const Eigen::VectorXd t = settled.times.array() - settled.times.mean();
  const Eigen::MatrixX2d places = settled.positions.leftCols<2>();
  const Eigen::Vector2d drift = circle_centre(settled.velocities.leftCols<2>());
  Eigen::MatrixX2d relative = places - t * drift.transpose();
  relative.rowwise() -= circle_centre(relative).transpose();
  Eigen::MatrixX4d basis(t.size(), 4);
  for (int round = 0; round < 5; ++round) {
    basis.col(0).setOnes();
    basis.col(1) = t;
    for (Eigen::Index k = 0; k < t.size(); ++k) {
      const double radius = relative.row(k).norm();
      basis.row(k).tail<2>() =
          radius > 0.0 ? Eigen::RowVector2d(relative.row(k) / radius) : Eigen::RowVector2d(0, 0);
    }
    const Eigen::MatrixXd normal = basis.transpose() * basis, sides = basis.transpose() * places;
    const Eigen::MatrixXd fit = normal.ldlt().solve(sides);
    if (!fit.allFinite()) break;
    relative = places - basis.leftCols<2>() * fit.topRows<2>();
  }
  return relative;
}

void add_revolution(const SmoothedMotion& settled, Features& features) {
  const Eigen::MatrixX2d velocities = settled.velocities.leftCols<2>();
  const MainDirections main = main_directions(velocities.rowwise() - velocities.colwise().mean());
  // Along a line the sense of a revolution would be that of the rounding.
  constexpr double kFlat = 1e-6;
  if (main.second_variance <= kFlat * main.first_variance) {
    features[Feature::turns] = features[Feature::winding] = 0.0;
    return;
  }
  const Eigen::MatrixX2d relative = about_drifting_centre(settled);
  double net = 0.0, total = 0.0;
  for (Eigen::Index k = 1; k < relative.rows(); ++k) {
    const Eigen::Vector2d a = relative.row(k - 1), b = relative.row(k);
    const double step = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    net += step;
    total += std::abs(step);
  }
  const Eigen::VectorXd radii = relative.rowwise().norm();
  const double mean = radii.mean();
  features[Feature::turns] = std::abs(net) / (2.0 * std::numbers::pi);
  if (total > 0.0) features[Feature::winding] = std::abs(net) / total;
  const double noise = settled.position_noise * settled.position_noise;
  const double scatter = (radii.array() - mean).square().mean() - noise;
  if (mean > 0.0) features[Feature::wobble] = std::sqrt(std::max(0.0, scatter)) / mean;
}

/// Frames of the reversals along the main direction of the horizontal velocity.
std::vector<Eigen::Index> veers_of(const SmoothedMotion& motion) {
  const Eigen::MatrixX2d horizontal = motion.velocities.leftCols<2>();
  const MainDirections main = main_directions(horizontal);
  const Eigen::VectorXd along = horizontal * main.first;
  const double band = std::max(0.15 * std::sqrt(main.first_variance), 4.0 * motion.velocity_noise);
  std::vector<Eigen::Index> frames;
  double side = 0.0;
  for (Eigen::Index k = 0; k < along.size(); ++k) {
    if (std::abs(along[k]) <= band) continue;
    if (side * along[k] < 0.0) frames.push_back(k);
    side = along[k];
  }
  return frames;
}

/// The fastest points of the fall, of which there is one a swing.
std::vector<Eigen::Index> dips_of(const SmoothedMotion& motion) {
  const double speed = std::sqrt(motion.velocities.rowwise().squaredNorm().mean());
  std::vector<Eigen::Index> frames =
      turning_points(motion.velocities.col(2), std::max(0.1 * speed, 5.0 * motion.velocity_noise));
  std::vector<Eigen::Index> every_second;
  for (std::size_t k = 1; k < frames.size(); k += 2) every_second.push_back(frames[k]);
  return every_second;
}

void add_path_features(const SmoothedMotion& whole, const SmoothedMotion& settled, double length,
                       Features& features) {
  const Eigen::Index last = settled.frame_count() - 1;
  const double time = settled.times[last] - settled.times[0];
  const Eigen::RowVector3d way = settled.positions.row(last) - settled.positions.row(0);
  features[Feature::fall] = -way.z() / time;
  features[Feature::drift] = way.head<2>().norm() / std::abs(way.z());
  double walked = 0.0;
  for (Eigen::Index k = 1; k <= last; ++k) {
    const double step = 0.5 * (settled.times[k] - settled.times[k - 1]);
    walked +=
        step * (settled.velocities.row(k - 1).head<2>().norm() + settled.velocities.row(k).head<2>().norm());
  }
  if (walked > 0.0) features[Feature::straightness] = std::min(1.0, way.head<2>().norm() / walked);
  const double speed = std::abs(features[Feature::fall]);
  const double noise = settled.ground_directions * settled.velocity_noise * settled.velocity_noise;
  const double sway = settled.velocities.leftCols<2>().rowwise().squaredNorm().mean() - noise;
  features[Feature::sway] = std::sqrt(std::max(0.0, sway)) / speed;
  features[Feature::sway_noise] = std::sqrt(noise) / speed;
  features[Feature::veers] = static_cast<double>(veers_of(settled).size());
  if (length > 0.0) {
    features[Feature::excursion] =
        (whole.positions.leftCols<2>().rowwise() - whole.positions.row(0).head<2>())
            .rowwise()
            .norm()
            .maxCoeff() /
        length;
    features[Feature::lengths] = std::abs(way.z()) / length;
  }
  Eigen::MatrixX2d ground = settled.positions.leftCols<2>();
  ground -= (settled.times.array() - settled.times[0]).matrix() / time * way.head<2>();
  ground.rowwise() -= ground.colwise().mean().eval();
  const Eigen::VectorXd main = ground * main_directions(ground).first;
  const std::vector<double> places(main.begin(), main.end());
  features[Feature::amplitude] = 0.5 * (quantile(places, 0.95) - quantile(places, 0.05));
}

/// The source's two numbers, of the whole record.
void add_source_features(const SmoothedMotion& whole, Features& features) {
  Eigen::MatrixX2d ground = whole.positions.leftCols<2>();
  ground.rowwise() -= ground.row(0).eval();
  const Eigen::RowVector2d mean = ground.colwise().mean();
  features[Feature::d] = mean.norm();
  ground.rowwise() -= mean;
  const MainDirections main = main_directions(ground);
  const double noise = whole.position_noise * whole.position_noise;
  const double first = main.first_variance - noise;
  const double second = whole.ground_directions > 1 ? main.second_variance - noise : main.second_variance;
  if (first > 0.0) features[Feature::e] = std::sqrt(1.0 - std::max(0.0, second) / first);
}

void check_options(const FeatureOptions& options) {
  require(options.settle_share >= 0.0 && options.settle_share < 1.0, "settle_share", options.settle_share,
          "a number from 0 to below 1");
  if (options.settle) require_not_negative(*options.settle, "settle");
  if (options.exponent)
    require(std::isfinite(*options.exponent), "exponent", *options.exponent, "a finite number");
  const auto require_margin = [](double margin, const char* name) {
    require(margin >= 0.0 && margin < 0.5 * std::numbers::pi, name, margin, "an angle from 0 to below pi/2");
  };
  require_margin(options.flip_margin_plane, "flip_margin_plane");
  require_margin(options.flip_margin_space, "flip_margin_space");
  require_margin(options.swing_margin, "swing_margin");
}

Eigen::Index settled_frame(const SmoothedMotion& motion, const FeatureOptions& options) {
  const Eigen::Index frames = motion.frame_count();
  const double begin = motion.times[0];
  const double settle =
      options.settle ? *options.settle : options.settle_share * (motion.times[frames - 1] - begin);
  Eigen::Index first = 0;
  while (first < frames && motion.times[first] < begin + settle * (1.0 - 1e-12)) ++first;
  require(frames - first >= kFewestFrames, "settle", settle, "a time that leaves 12 frames or more");
  return first;
}

}  // namespace

const std::vector<FeatureInfo>& feature_infos() {
  static const std::vector<FeatureInfo> infos = {
      {"tilt", "rad", "95 % point of the angle of the normal from the vertical (plane: 5 to 95 % range)",
       true},
      {"flips", "1", "changes of the side that faces down", true},
      {"coherence", "1", "half turns the same way: 1; there and back: -1 (plane: 0)", true},
      {"reversals", "1", "of the rotation, per half turn walked", true},
      {"recurrence", "1", "distance of the path to itself, a period later: 0 repeats, 1 never"},
      {"spread", "1", "Lyapunov exponent times the time of a swing"},
      {"turns", "1", "revolutions of the place about its drifting centre"},
      {"winding", "1", "of the revolutions, net over total"},
      {"wobble", "1", "deviation of their radius over its mean"},
      {"sway", "1", "rms horizontal velocity over the speed of fall"},
      {"veers", "1", "reversals of the horizontal velocity"},
      {"excursion", "1", "largest horizontal distance from the start, in lengths of the body"},
      {"swings", "1", "in the settled part"},
      {"swing_time", "s", "mean time of a swing"},
      {"drift", "1", "horizontal way over height fallen"},
      {"straightness", "1", "net horizontal way over the way walked along the ground"},
      {"fall", "m/s", "mean speed downward"},
      {"frequency", "1/s", "of two swings"},
      {"amplitude", "m", "half the 5 to 95 % range of the main horizontal direction"},
      {"d", "m", "distance from the first point to the mean of the points on the ground"},
      {"e", "1", "eccentricity of the points on the ground"},
      {"tilt_noise", "rad", "what noise alone makes of the tilt", true},
      {"sway_noise", "1", "what noise alone makes of the sway"},
      {"frame_angle", "rad", "largest turn between two frames", true},
      {"lengths", "1", "lengths of the body fallen in the settled part"},
  };
  return infos;
}

Feature feature_of(std::string_view name) {
  std::vector<std::string> known;
  for (std::size_t k = 0; k < kFeatures; ++k) {
    if (feature_infos()[k].name == name) return static_cast<Feature>(k);
    known.push_back(feature_infos()[k].name);
  }
  throw ArgumentError(fmt::format("there is no feature \"{}\"{}", name, suggestion(name, known)));
}

std::string to_string(Seen seen) {
  switch (seen) {
    case Seen::plane:
      return "plane";
    case Seen::space:
      return "space";
    case Seen::positions:
      return "positions";
  }
  throw ArgumentError("no such kind of record");
}

Features features(const MotionRecord& record, const FeatureOptions& options) {
  return features(smoothed(record), record.length, options);
}

Features features(const SmoothedMotion& motion, double length, const FeatureOptions& options) {
  check_options(options);
  const Eigen::Index first = settled_frame(motion, options);
  const SmoothedMotion settled = part(motion, first, motion.frame_count() - first);
  Features all;
  all.seen = !motion.has_attitude() ? Seen::positions : motion.is_planar() ? Seen::plane : Seen::space;
  add_path_features(motion, settled, length, all);
  add_source_features(motion, all);
  if (motion.has_attitude()) {
    add_attitude_features(settled, options, all);
  } else {
    all[Feature::swings] = static_cast<double>(swing_frames(settled, options).size());
  }
  if (!motion.is_planar()) add_revolution(settled, all);
  const double time = settled.times[settled.frame_count() - 1] - settled.times[0];
  if (all[Feature::swings] > 0.0) {
    all[Feature::swing_time] = time / all[Feature::swings];
    all[Feature::frequency] = 0.5 / all[Feature::swing_time];
    all[Feature::recurrence] = recurrence(settled, all[Feature::swing_time]);
    if (options.exponent) all[Feature::spread] = *options.exponent * all[Feature::swing_time];
  }
  return all;
}

std::vector<Eigen::Index> swing_frames(const SmoothedMotion& motion, const FeatureOptions& options) {
  if (motion.has_attitude()) return attitude_swings(motion, options);
  const std::vector<Eigen::Index> veers = veers_of(motion), dips = dips_of(motion);
  return veers.size() >= dips.size() ? veers : dips;
}

}  // namespace samara::motion
