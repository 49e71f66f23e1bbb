#pragma once

#include <array>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "samara/models/interface/model.h"

namespace samara::motion {

/// Which states of a model are place, attitude and velocities of a body. World axes: z up; planar motions, whose models
/// have y up, in y = 0.
struct StateLayout {
  bool is_planar = false;
  std::array<std::size_t, 3> position = {};  ///< x, y, z; of a plane x, y
  std::array<std::size_t, 4> attitude = {};  ///< qw, qx, qy, qz; of a plane theta
  bool has_velocities = false;
  std::array<std::size_t, 3> velocity = {};  ///< ux, uy, uz; of a plane vx, vy; along body axes
  std::array<std::size_t, 3> rate = {};      ///< wx, wy, wz; of a plane w

  /// By names. @returns nothing unless there are x, y, z with qw, qx, qy, qz, or x, y with theta and no z
  static std::optional<StateLayout> of(const models::ModelInfo& info);

  std::span<const std::size_t> positions() const { return std::span(position).first(is_planar ? 2 : 3); }
  std::span<const std::size_t> attitudes() const { return std::span(attitude).first(is_planar ? 1 : 4); }
  std::span<const std::size_t> velocities() const {
    return std::span(velocity).first(!has_velocities ? 0 : is_planar ? 2 : 3);
  }
  std::span<const std::size_t> rates() const {
    return std::span(rate).first(!has_velocities ? 0 : is_planar ? 1 : 3);
  }

  Eigen::Vector3d place(std::span<const double> state) const {
    if (is_planar) return {state[position[0]], 0.0, state[position[1]]};
    return {state[position[0]], state[position[1]], state[position[2]]};
  }
  /// @param place world; y is dropped in a plane
  void put_place(const Eigen::Vector3d& place, std::span<double> state) const {
    state[position[0]] = place.x();
    state[position[1]] = is_planar ? place.z() : place.y();
    if (!is_planar) state[position[2]] = place.z();
  }
};

}  // namespace samara::motion
