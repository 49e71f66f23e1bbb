#pragma once

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "options/arguments.h"
#include "samara/models/bodies/body_pose.h"
#include "samara/models/bodies/triangle_mesh.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Motions as files for viewers: what `query` and `simulate` write to a .glb or .usda.
namespace samara::apps {

struct Animation {
  models::PoseStates states;
  models::TriangleMesh body;
  std::string model;
  std::map<std::string, double> parameters;                     ///< SI
  std::vector<std::pair<std::string, std::string>> notes = {};  ///< what it was made from
  double from = 0.0, to = 0.0;                                  ///< s
  const models::TrajectoryFamily* family = nullptr;
  std::vector<double> q = {};  ///< its point
};

/// The pose of a model. @throws ArgumentError if it moves no body
models::PoseStates animated_states(const models::ModelInfo& info);

/// The body that was asked for, else what the parameters say.
/// @throws ArgumentError if they do not say it
models::TriangleMesh animated_body(const ShownWords& words, const models::ParametricModel& model,
                                   std::span<const double> q);

/// Keys are within 0.4 degrees and 8e-4 of the body's size of the motion. One that ends early is written to its end,
/// with a warning.
/// @returns the exit code
/// @throws ArgumentError if the family lacks a state of the pose; OutsideBoxError and NoResultError if there is no
/// motion at all; NoResultError for more than 200,000 keys
int write_animation(const std::string& path, const Animation& animation);

/// Of a motion whose states are there already, at times between which the body turns by less than 60 degrees; no
/// family is asked.
/// @param states times x states of `info`
/// @throws NoResultError if it turns further
void write_animation(const std::string& path, const Animation& animation, const models::ModelInfo& info,
                     const Eigen::VectorXd& times, const Eigen::MatrixXd& states);

}  // namespace samara::apps
