#pragma once

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/trajectories/interval.h"

namespace samara::identification {

/// A parameter of the model that is known roughly, and may drift: c' = drift times white noise, or (ln c)' so.
struct FollowedCoefficient {
  std::string name = {};
  double value = 0.0;      ///< SI, before a frame was seen
  double deviation = 0.0;  ///< of the value; of its logarithm if logarithmic: 0.1 is 10 %
  double drift = 0.0;      ///< per sqrt(s): after t seconds it has gone drift sqrt(t), in the mean square
  bool logarithmic = false;
  bool own = false;  ///< of this motion alone, not one of all motions from which this one may differ
  /// It is held at a bound that it reaches [SI].
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};

/// Where a state may be at the first frame, if no frame says: a normal distribution.
struct FollowedStart {
  double mean = 0.0;
  double deviation = 0.0;  ///< 0: it is there
};

/// What comes over the motion besides the model: white noise in the rates of states, each in the unit of the state
/// per sqrt(s).
struct ModelNoise {
  double velocity = 0.0;  ///< of states in m/s; m/s per sqrt(s)
  double rate = 0.0;      ///< of states in rad/s or 1/s; rad/s per sqrt(s)
  /// Of single states, by name, in place of the above.
  std::map<std::string, double> states = {};
};

/// How errors of a state become errors of what comes later.
enum class ForecastOrder {
  first,   ///< by the derivatives of the motion
  second,  ///< by motions from either side, which follow its bends, too
};

struct FollowOptions {
  // What is seen.

  /// Outputs that are measured (states, or outputs that follow from them), with the standard deviation of a frame's
  /// value, SI.
  std::map<std::string, double> noise = {};
  /// rad, about each axis: the attitude is measured, too.
  std::optional<double> attitude_noise = {};
  /// Outputs that repeat, with their periods, SI. Those in rad do by 2 pi unless they are named here; 0 for none.
  std::map<std::string, double> periods = {};
  /// Each frame is the mean of so many frames, centred on it; odd. Frames must come at about equal times.
  int averaged_frames = 1;

  // What moves.

  std::map<std::string, double> fixed = {};  ///< parameters and initial values that are held, SI
  std::vector<FollowedCoefficient> coefficients = {};
  /// Of the coefficients' steps (of logarithms where logarithmic), in place of their deviations; empty: independent.
  Eigen::MatrixXd coefficient_covariance = {};
  ModelNoise model_noise = {};
  double step = 2e-3;  ///< s: upper bound of the Runge-Kutta steps

  // Where it starts.

  /// Of states that no frame shows. Those that are neither here nor fixed, and not measured, stay at the model's
  /// default initial value. An attitude (its four states) that is neither measured nor fixed is not known at all, and
  /// so is an angle (in rad) that may start anywhere on its circle. All of this is of the first frame: where a
  /// motion that was lost is looked for again, states that frames show are left to them, and others may be as far
  /// from there as they have been. The spins of a round body that are held stay so.
  std::map<std::string, FollowedStart> start = {};
  /// Frames from which the start is found; the motion is followed from the last of them on.
  int start_frames = 8;
  /// A turn of the body about its z axis, or over, changes nothing: attitudes are told by where z points.
  bool round_body = false;
  ForecastOrder forecasts = ForecastOrder::second;
  /// Frames are kept for Follower::smoothed(); memory grows with them.
  bool remember = false;
};

}  // namespace samara::identification
