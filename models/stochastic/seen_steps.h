#pragma once

#include <Eigen/Core>

#include "samara/models/stochastic/air_along_path.h"

namespace samara::models {

/// The fluid where bodies side by side are.
struct FluidByLane {
  explicit FluidByLane(Eigen::Index lanes);

  VectorsByLane mean;            ///< velocity [m/s]
  MatricesByLane mean_gradient;  ///< [1/s]
  VectorsByLane sigma_gradient;  ///< [1/s]
  Eigen::ArrayXd sigma;          ///< deviation of a component [m/s]; 0: still
  Eigen::ArrayXd sigma_seen;     ///< of what a body sees of it [m/s]
  Eigen::ArrayXd T;              ///< of particles of the fluid [s]
  Eigen::ArrayXd crossing;       ///< b/sigma, where bodies cross the eddies [s/m]; 0: not asked for
  Eigen::ArrayXd steps;          ///< h/T of the coming step
  Eigen::ArrayXd blend;          ///< weight of that step in the mean relative velocity
  Eigen::ArrayXd eddy_rate;      ///< of a rotational gust [1/s]; 0: there is none
  Eigen::ArrayXd inside;         ///< 1, or 0 beyond the flow
};

/// The gusts of the fluid that bodies side by side see, step by step (fluid_seen.h says by which equations).
class SeenSteps {
 public:
  /// @param varies whether the flow has gradients anywhere  @param turns whether there are rotational gusts
  SeenSteps(Eigen::Index lanes, bool varies, bool turns);

  /// @param noise, spin_noise standard normals
  void start(const BodiesOnPath& bodies, const FluidByLane& here, const VectorsByLane& noise,
             const VectorsByLane& spin_noise);

  /// Takes the gusts to the end of a step of length h [s].
  void move(const BodiesOnPath& bodies, double h, const FluidByLane& middle, const VectorsByLane& noise,
            const VectorsByLane& spin_noise);

  /// Where bodies will be then: their own change of velocity by this gust moves them, too; without it what the fluid
  /// carries does not stay mixed.
  const VectorsByLane& places() const { return places_; }

  /// What they see of the fluid there.
  void tell(const FluidByLane& there, AirsSeen& seen) const;

 private:
  template <class S>
  void move_some(Eigen::Index lane, const BodiesOnPath& bodies, double h, const FluidByLane& middle,
                 const VectorsByLane& noise, const VectorsByLane& spin_noise);
  template <class S>
  void tell_some(Eigen::Index lane, const FluidByLane& there, AirsSeen& seen) const;

  Eigen::Index lanes_;
  bool varies_, turns_;
  /// BodyOnPath::follows, between 0 and 1 along its axes.
  Eigen::Matrix3d at_once_ = Eigen::Matrix3d::Zero();
  VectorsByLane w_, spin_;
  /// Relative to the fluid seen, averaged over ten times an eddy's: what a particle of the fluid has is zero.
  VectorsByLane mean_u_r_;
  VectorsByLane places_;
  MatricesByLane gradient_;  ///< AirSeen::gradient and time_scale, of the step
  Eigen::ArrayXd time_scale_;
};

}  // namespace samara::models
