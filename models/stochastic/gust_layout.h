#pragma once

#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "samara/models/interface/model.h"
#include "samara/models/stochastic/air_along_path.h"

namespace samara::models {

/// Terms of a law that do not take up a gust: weight, the pressure of a fluid that accelerates, rates of axes,
/// propellers.
inline constexpr std::string_view kNotDrag[] = {"inertia", "gravity and buoyancy", "ambient acceleration",
                                                "thrust"};

/// How gusts reach a model: by parameters of these names, and states of these kinds. A law of one's own that has them
/// flies through gusts like those of Samara.
///
///   in space   gust_start, gust_{x,y,z}, gust_rate_{x,y,z}, gust_gradient_{xx,xy,..,zz}, gust_spin_{x,y,z}
///              with a group of states `position`, and either a quaternion and velocities u, w in body axes after it,
///              or two vectors, v and w
///   in a plane gust_start, gust_{x,y}, gust_rate_{x,y}, gust_gradient_{xx,xy,yx,yy}, gust_spin
///              with the states vx, vy, w, theta, x, y of falling_plate, y upward
///
/// The rate is that along the path of the body; along the path of the fluid it is rate + gradient (gust - v), with
/// gradient_xy the change of the component x along y.
///
/// In the world of the flow a plane is that of x and z. Of a law's force terms those of the names in kNotDrag are not
/// counted as drag, where the time in which the body takes up a gust is needed.
class GustLayout {
 public:
  enum class Space { body, point, plane };

  /// @throws ArgumentError saying what the model lacks.
  explicit GustLayout(const Model& model);

  Space space() const { return space_; }
  bool has_attitude() const { return space_ != Space::point; }
  /// BodyOnPath::axes
  Eigen::Vector3d axes() const { return {1.0, space_ == Space::plane ? 0.0 : 1.0, 1.0}; }
  /// Of the place, in the order of the model: x, y, z, or x, y. The last one is the height.
  const std::vector<int>& position() const { return position_; }
  /// Of the velocity, in the order of the model, in body axes where there is an attitude.
  const std::vector<int>& velocity() const { return velocity_; }
  /// Of the angular velocity.
  const std::vector<int>& rotation() const { return rotation_; }
  /// Of the first number of the quaternion, or of theta; -1: there is no attitude.
  int attitude() const { return attitude_; }
  /// All of them.
  const std::vector<std::string>& parameter_names() const { return names_; }
  /// Their indices, in the order above.
  const std::vector<int>& parameters() const { return parameters_; }

  /// Place, velocity and attitude in the world; the rest of `motion` stays.
  /// @param state of which state(i) gives state i
  template <class State>
  void read(const State& state, BodyOnPath& motion) const;

  /// Sets the ramp of one step: set(parameter, value).
  template <class Set>
  void write(const Set& set, double start, const Eigen::Vector3d& velocity, const Eigen::Vector3d& rate,
             const Eigen::Matrix3d& gradient = Eigen::Matrix3d::Zero(),
             const Eigen::Vector3d& spin = Eigen::Vector3d::Zero()) const;

  /// BodyOnPath::follows in body axes, from the accelerations that the model gives for unit rates of the air.
  /// @param p complete, all given
  Eigen::Matrix3d follows(const Model& model, std::span<const double> x, ParameterValues p) const;

 private:
  Space space_ = Space::body;
  std::vector<std::string> names_;
  std::vector<int> parameters_;  ///< indices, in the order of names_
  std::vector<int> position_, velocity_, rotation_;
  int attitude_ = -1;  ///< of the quaternion, or of theta
};

/// Radius of the disc of the area of a body's outline [m], from the parameters that say it (a and b, semi_chord,
/// the reference area, diameter); 0 where none does.
double outline_radius(const ModelInfo& info, std::span<const double> parameters);

template <class State>
void GustLayout::read(const State& state, BodyOnPath& motion) const {
  const auto vector = [&](const std::vector<int>& of) {
    return Eigen::Vector3d(state(of[0]), state(of[1]), state(of[2]));
  };
  if (space_ == Space::plane) {
    const double c = std::cos(state(attitude_)), s = std::sin(state(attitude_));
    motion.attitude << c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c;
    motion.position = {state(position_[0]), 0.0, state(position_[1])};
    motion.velocity = motion.attitude * Eigen::Vector3d(state(velocity_[0]), 0.0, state(velocity_[1]));
    return;
  }
  motion.position = vector(position_);
  motion.velocity = vector(velocity_);
  if (space_ == Space::body) {
    const double w = state(attitude_), x = state(attitude_ + 1), y = state(attitude_ + 2),
                 z = state(attitude_ + 3);
    const double k = 2.0 / (w * w + x * x + y * y + z * z);
    motion.attitude << 1.0 - k * (y * y + z * z), k * (x * y - w * z), k * (x * z + w * y),  //
        k * (x * y + w * z), 1.0 - k * (x * x + z * z), k * (y * z - w * x),                 //
        k * (x * z - w * y), k * (y * z + w * x), 1.0 - k * (x * x + y * y);
    motion.velocity = motion.attitude * motion.velocity;
  }
}

template <class Set>
void GustLayout::write(const Set& set, double start, const Eigen::Vector3d& velocity,
                       const Eigen::Vector3d& rate, const Eigen::Matrix3d& gradient,
                       const Eigen::Vector3d& spin) const {
  std::size_t next = 0;
  const auto is_seen = [this](int axis) { return axis != 1 || space_ != Space::plane; };
  set(parameters_[next++], start);
  for (const Eigen::Vector3d* vector : {&velocity, &rate}) {
    for (int i = 0; i < 3; ++i) {
      if (is_seen(i)) set(parameters_[next++], (*vector)[i]);
    }
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (is_seen(i) && is_seen(j)) set(parameters_[next++], gradient(i, j));
    }
  }
  // theta turns from x to z, the axis y of the world the other way.
  if (space_ == Space::plane) return set(parameters_[next], -spin.y());
  for (int i = 0; i < 3; ++i) set(parameters_[next++], spin[i]);
}

}  // namespace samara::models
