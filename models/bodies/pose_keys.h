#pragma once

#include <functional>
#include <vector>

#include "samara/models/bodies/body_pose.h"

namespace samara::models {

/// How far a motion may be from the straight line and the even turn between two keys.
struct PoseKeyLimits {
  double angle = 0.4 * 0.017453292519943295;  ///< rad
  double distance = 0.0;                      ///< more than 0, in the unit of lengths
  int most = 200000;                          ///< keys
};

/// A motion at instants so dense that what lies between them follows by interpolation.
struct PoseKeys {
  std::vector<double> times;
  std::vector<BodyPose> poses;
  bool is_dense = false;  ///< false: there would be more than `most`
};

/// Halves the intervals between keys, from 64 of equal length on, until the motion at a quarter, at the half and at three
/// quarters of each is within the limits, or the interval is shorter than a millionth of the whole: a jump, as where
/// pieces of a codebook meet, stands between two keys. Times increase, as single precision, too.
/// @param poses_at of times between from and to, which increase
/// @throws ArgumentError if from < to does not hold, or a limit is not positive
PoseKeys dense_pose_keys(const std::function<std::vector<BodyPose>(const std::vector<double>&)>& poses_at,
                         double from, double to, const PoseKeyLimits& limits);

}  // namespace samara::models
