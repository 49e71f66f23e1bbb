#pragma once

#include <Eigen/Core>

#include "samara/models/batch/lanes.h"
#include "samara/models/stochastic/air_along_path.h"
#include "samara/models/stochastic/gust_layout.h"

namespace samara::models {

/// What a driver does with bodies side by side at each step: sets the ramp of the air that each of them meets, and
/// looks where they have come to. What it holds of a lane depends on nothing but that lane.
class GustRamps {
 public:
  /// @param width lanes of the kernel that flies the bodies
  GustRamps(const GustLayout& layout, int width);

  /// Of all rows: those of the kernel, and what is missing to whole registers.
  Eigen::Index lanes() const { return half_turns_.size(); }

  /// Place, velocity and attitude at the start; counts turns from there on.
  void start(const Lanes& flown, BodiesOnPath& bodies);

  /// Sets the ramps of a step of length h [s] from what the air will be at its end, which becomes `bodies.air`. Where
  /// the flow ends the air stays as it is. @returns whether the air of a body that flies is not finite
  bool set(double t, double h, const AirsSeen& seen, BodiesOnPath& bodies, Lanes& flown);

  /// Place, velocity, attitude and acceleration after it.
  /// @param ground height [m] @returns whether a body that flies is at or below it, or not finite
  bool look(double h, double ground, const Lanes& flown, BodiesOnPath& bodies);

  /// Places before the last step.
  const VectorsByLane& before() const { return before_; }

  /// How often a body has turned over, by which of its sides is up. Edge-on is neither, so that it does not flicker.
  int half_turns(Eigen::Index lane) const { return static_cast<int>(half_turns_[lane]); }

 private:
  template <class S>
  void read(Eigen::Index lane, const Lanes& flown, BodiesOnPath& bodies);
  template <class S>
  bool set_some(Eigen::Index lane, double t, double h, const AirsSeen& seen, BodiesOnPath& bodies,
                Lanes& flown);
  template <class S>
  bool look_some(Eigen::Index lane, double h, double ground, const Lanes& flown, BodiesOnPath& bodies);
  template <class S>
  void count_turns(Eigen::Index lane, const S& normal_z);

  const GustLayout& layout_;
  int width_;
  VectorsByLane before_, followed_;  ///< of the change of velocity in this step, the gust's at once
  Eigen::ArrayXd side_, half_turns_;
};

}  // namespace samara::models
