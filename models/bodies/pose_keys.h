#pragma once

#include <functional>
#include <vector>

#include "samara/models/bodies/body_pose.h"

namespace samara::models {

/// How far a motion may be from the straight line and the even turn between two keys (players take the shorter turn, so
/// that a turn near pi may come out backwards).
struct PoseKeyLimits {
  double angle = 0.4 * 0.017453292519943295;  ///< rad
  double distance = 0.0;                      ///< more than 0, in the unit of lengths
  double turn = 60.0 * 0.017453292519943295;  ///< rad, from key to key
  int most = 200000;                          ///< keys
};

/// A motion at instants so dense that what lies between them follows by interpolation.
struct PoseKeys {
  std::vector<double> times;
  std::vector<BodyPose> poses;
  bool is_dense = false;  ///< false: there would be more than `most`
};

/// Halves the intervals between keys, from 64 of equal length on, until the motion at a quarter, at the half and at
/// three quarters of each is within the limits, or the interval is shorter than a millionth of the whole: a jump, as
/// where pieces of a codebook meet, stands between two keys. Times increase, as single precision, too.
/// @param poses_at of times between from and to, which increase
/// @throws ArgumentError if from < to does not hold, or a limit is not positive
PoseKeys dense_pose_keys(const std::function<std::vector<BodyPose>(const std::vector<double>&)>& poses_at,
                         double from, double to, const PoseKeyLimits& limits);

/// Keys of a motion that is seen pose by pose, as it goes on: of the poses those between which all others are within
/// the limits.
class PoseTrack {
 public:
  /// @throws ArgumentError if a limit is not positive
  explicit PoseTrack(const PoseKeyLimits& limits);

  /// @param t later than before. @throws ArgumentError otherwise
  void add(double t, const BodyPose& pose);

  std::size_t seen() const { return seen_; }
  /// Up to the pose that was seen last. is_dense: no two poses that followed each other turned by more than the limit.
  PoseKeys keys() const;

 private:
  bool covers_waiting(double t, const BodyPose& pose) const;

  PoseKeyLimits limits_;
  PoseKeys keys_;
  PoseKeys waiting_;  ///< seen since the last key
  std::size_t seen_ = 0;
};

}  // namespace samara::models
