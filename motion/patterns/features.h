#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "samara/motion/records/motion_record.h"
#include "samara/motion/records/smoothed_motion.h"

/// Numbers that tell how a body falls. None of them changes when the world is turned about the vertical or mirrored,
/// when the plate is replaced by its symmetric copy, or with the frame rate (as long as a half turn has six frames);
/// those of unit 1 and rad do not change with the units of length and time either. Noise is subtracted from every
/// variance.
namespace samara::motion {

enum class Feature : std::size_t {
  tilt,  ///< 95 % point of the angle of the normal from the vertical; of a planar motion, 5 to 95 % range of theta
  flips,       ///< changes of the side that faces down
  coherence,   ///< 1: every half turn goes the same way; there and back: 0 in a plane, -1 in space
  reversals,   ///< of the rotation about its main axis, per half turn walked
  recurrence,  ///< 0: repeats itself exactly, 1: never, see features.cpp
  spread,      ///< Lyapunov exponent times the time of a swing; known of simulations that were asked for it
  turns,       ///< revolutions of the place about its drifting centre
  winding,     ///< of these, net over total
  wobble,      ///< deviation of the radius over its mean
  sway,        ///< rms horizontal velocity about its mean, and that mean, over the speed of fall
  veers,       ///< reversals of the horizontal velocity along its main direction
  excursion,   ///< largest horizontal distance from the start, over the body's length
  swings,  ///< in the settled part: turning points and flips of the attitude, or veers and dips of the speed
  swing_time,    ///< s
  drift,         ///< horizontal way over height fallen
  straightness,  ///< net horizontal way over the way walked along the ground; 1: always onward
  fall,          ///< m/s, mean speed downward
  frequency,     ///< Hz, of two swings
  amplitude,     ///< m, half the 5 to 95 % range of the main horizontal direction, drift removed
  d,  ///< m, from the first point to the mean of the points on the ground (dissertation, section 5.4.2)
  e,  ///< sqrt(1 - l2/l1) of their covariance (likewise)
  tilt_noise,   ///< rad, what noise alone would make of the tilt, before it is subtracted
  sway_noise,   ///< what noise alone would make of the sway
  frame_angle,  ///< rad, largest turn between two frames
  lengths       ///< lengths of the body fallen in the settled part
};

inline constexpr std::size_t kFeatures = 25;

struct FeatureInfo {
  std::string name, unit, meaning;
  bool needs_attitude = false;
};
/// In the order of Feature.
const std::vector<FeatureInfo>& feature_infos();
/// @throws ArgumentError naming the nearest.
Feature feature_of(std::string_view name);

/// What a record shows, which decides on the thresholds that are used.
enum class Seen { plane, space, positions };
std::string to_string(Seen seen);

struct Features {
  Features() { values.fill(std::numeric_limits<double>::quiet_NaN()); }
  double operator[](Feature feature) const { return values[static_cast<std::size_t>(feature)]; }
  double& operator[](Feature feature) { return values[static_cast<std::size_t>(feature)]; }
  bool knows(Feature feature) const { return std::isfinite((*this)[feature]); }

  Seen seen = Seen::positions;
  std::array<double, kFeatures> values;  ///< NaN where it is not known
};

struct FeatureOptions {
  /// Part of the record that is left out at its beginning, while the motion settles: a share, or, if given, a time
  /// [s] after its first frame.
  double settle_share = 0.5;
  std::optional<double> settle = {};
  /// Lyapunov exponent [1/s], of a simulation that knows it.
  std::optional<double> exponent = {};
  /// How far beyond edge-on a side must come to face down [rad]; how far a swing goes back to count [rad].
  double flip_margin_plane = 0.35, flip_margin_space = 0.2, swing_margin = 0.1;
};

/// @throws ArgumentError as check(record), and for options outside their meaning.
Features features(const MotionRecord& record, const FeatureOptions& options = {});

/// The same of a motion that is smoothed already. @param length m, 0: not known
Features features(const SmoothedMotion& motion, double length, const FeatureOptions& options = {});

/// Frames of the swings that Feature::swings counts, in order.
std::vector<Eigen::Index> swing_frames(const SmoothedMotion& motion, const FeatureOptions& options = {});

}  // namespace samara::motion
