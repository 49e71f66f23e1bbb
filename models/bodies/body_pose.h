#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/model.h"

/// Where the body of a model is and how it stands, for pictures and animations.
namespace samara::models {

/// A pose in a world with z up: models in a plane move in x and z.
struct BodyPose {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();   ///< of the body's origin [the model's unit of length]
  Eigen::Vector4d q_WB = Eigen::Vector4d::UnitX();  ///< (w, x, y, z), body to world, of length one
};

/// Which states of a model are its pose.
struct PoseStates {
  enum class Kind {
    line,   ///< {height, or depth}: up or down, without turning
    plane,  ///< {x, y, theta}: y upward, theta from world x to body x; the body's normal, or y', is its z
    point,  ///< {x, y, z}: without turning
    space,  ///< {x, y, z, qw, qx, qy, qz}
  };
  Kind kind = Kind::point;
  std::vector<std::string> names;  ///< of the states
  std::string unit;                ///< of lengths
  bool is_downward = false;        ///< of a line: positive downward

  /// @param values of `names`, in their order
  BodyPose pose(std::span<const double> values) const;
};

/// By the groups of states of a model, else by the names of its states: x, y (or z) and theta are a motion in a
/// plane; a single one of x, y, z is one along the vertical, downward where its description says so.
/// @returns nothing where the states are no motion of a body
std::optional<PoseStates> pose_states_of(const ModelInfo& info);

}  // namespace samara::models
