#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/models/laws/ambient_flow.h"
#include "samara/models/stochastic/gust_layout.h"
#include "samara/motion/records/state_layout.h"

namespace samara::motion {

/// The air that each of some bodies falls in. They meet events and look for pieces by their states relative to it: less
/// its velocity where they are, and less the way that it has gone about them.
class AirAboutBodies {
 public:
  /// @param model with the parameters of GustLayout
  AirAboutBodies(const models::Model& model, std::shared_ptr<const models::AmbientFlow> wind,
                 const StateLayout& layout, std::size_t count);

  /// Body n begins anew: the air has gone no way.
  void begin(Eigen::Index n) { air(n).carried.setZero(); }

  /// Looks at the air where body n is, and makes its state one relative to that.
  /// @param t s, of the wind
  void look(Eigen::Index n, double t, std::span<double> state);

  /// What the air of the last look is over the next step, in the order of GustLayout::parameter_names().
  /// @param t s, of the body's model, at which the step begins; h s, its length
  /// @param state of the body in the world
  void tell(Eigen::Index n, double t, double h, std::span<const double> state, std::span<double> values);

  /// Adds the air's velocity to that of a body which is to begin at rest in it.
  /// @param t s, of the wind
  void carry(double t, std::span<double> state) const;

 private:
  struct Air {
    models::AmbientSample now;                          ///< where the body is
    Eigen::Vector3d carried = Eigen::Vector3d::Zero();  ///< m, how far it has gone
  };
  Air& air(Eigen::Index n) { return airs_[static_cast<std::size_t>(n)]; }
  /// Of the world, along the axes of states: in a plane x and z.
  double along_axis(const Eigen::Vector3d& v, std::size_t k) const {
    return v[layout_.is_planar && k == 1 ? 2 : static_cast<Eigen::Index>(k)];
  }
  models::BodyOnPath motion_of(std::span<const double> state) const;

  models::GustLayout gusts_;
  std::shared_ptr<const models::AmbientFlow> wind_;
  StateLayout layout_;
  std::vector<Air> airs_;
};

}  // namespace samara::motion
