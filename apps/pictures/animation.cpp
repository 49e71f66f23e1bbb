#include "pictures/animation.h"

#include <algorithm>

#include <fmt/format.h>

#include "pictures/shown_bodies.h"
#include "samara/base/errors.h"
#include "samara/io/animated_scene.h"
#include "samara/models/bodies/pose_keys.h"
#include "samara/models/bodies/shown_body.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

std::vector<models::BodyPose> poses_of(const Animation& animation, const std::vector<double>& times) {
  const models::FamilyTrajectory motion =
      models::trajectory(*animation.family, animation.q, times, animation.states.names);
  std::vector<models::BodyPose> poses;
  poses.reserve(times.size());
  for (Eigen::Index i = 0; i < motion.values.rows(); ++i) {
    const Eigen::VectorXd row = motion.values.row(i).transpose();
    if (!row.allFinite()) {
      throw NoResultError(fmt::format("the motion is not finite at t = {:.6g}: {}",
                                      times[static_cast<std::size_t>(i)], motion.outcome.message));
    }
    poses.push_back(animation.states.pose({row.data(), static_cast<std::size_t>(row.size())}));
  }
  return poses;
}

/// How far the motion gets.
models::TrajectoryOutcome outcome_of(const Animation& animation) {
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(101, animation.from, animation.to);
  return models::trajectory(*animation.family, animation.q, {times.begin(), times.end()},
                            animation.states.names)
      .outcome;
}

io::AnimatedBody animated_track(const models::PoseKeys& keys) {
  const auto count = std::ssize(keys.times);
  io::AnimatedBody body{.name = "body",
                        .times = Eigen::Map<const Eigen::VectorXd>(keys.times.data(), count),
                        .positions = Eigen::Matrix3Xd(3, count),
                        .rotations = Eigen::Matrix4Xd(4, count)};
  for (Eigen::Index i = 0; i < count; ++i) {
    body.positions.col(i) = keys.poses[static_cast<std::size_t>(i)].p_WB;
    body.rotations.col(i) = keys.poses[static_cast<std::size_t>(i)].q_WB;
  }
  return body;
}

models::PoseKeyLimits limits_of(const Animation& animation) {
  return {.distance = 8e-4 * 2.0 * animation.body.vertices.colwise().norm().maxCoeff()};
}

void write_keys(const std::string& path, const Animation& animation, const models::PoseKeys& keys) {
  io::AnimatedScene scene{.name = animation.model,
                          .vertices = animation.body.vertices,
                          .triangles = animation.body.triangles,
                          .bodies = {animated_track(keys)},
                          .notes = animation.notes,
                          .parameters = animation.parameters};
  scene.notes.insert(scene.notes.begin(), {"model", animation.model});
  io::write_scene(path, scene);
}

}  // namespace

models::PoseStates animated_states(const models::ModelInfo& info) {
  const auto states = models::pose_states_of(info);
  if (states) return *states;
  throw ArgumentError(
      fmt::format("model \"{}\" does not move a body: no .glb or .usda was expected", info.name));
}

models::TriangleMesh animated_body(const ShownWords& words, const models::ParametricModel& model,
                                   std::span<const double> q) {
  if (const auto given = shown_mesh(words)) return *given;
  if (const auto own = models::shown_body(model, q)) return *own;
  throw ArgumentError(
      fmt::format("the parameters of \"{}\" do not say what its body looks like: --body was expected",
                  model.model().info().name));
}

int write_animation(const std::string& path, const Animation& animation) {
  for (const std::string& name : animation.states.names) {
    if (std::ranges::count(animation.family->info().outputs, name, &models::FamilyOutput::name) == 0)
      throw ArgumentError(
          fmt::format("{} is part of the pose, and no output: nothing can be animated", name));
  }
  const models::TrajectoryOutcome outcome = outcome_of(animation);
  const bool is_outside = outcome.status == models::TrajectoryStatus::outside_box;
  if (!outcome && !(outcome.reached > animation.from)) {
    if (is_outside) throw OutsideBoxError(outcome.message);
    throw NoResultError(outcome.message);
  }
  const double to = outcome ? animation.to : outcome.reached;
  const models::PoseKeys keys =
      models::dense_pose_keys([&](const std::vector<double>& times) { return poses_of(animation, times); },
                              animation.from, to, limits_of(animation));
  if (!keys.is_dense) {
    throw NoResultError(
        fmt::format("the motion needs more than {} keys to be within {:.1g} of its body and half a degree",
                    limits_of(animation).most, 1e-3));
  }
  write_keys(path, animation, keys);
  if (outcome) return kDone;
  warn(fmt::format("{}; the animation ends at t = {:.6g}", outcome.message, to));
  return is_outside ? kOutsideBox : kToleranceMissed;
}

void write_animation(const std::string& path, const Animation& animation, const models::ModelInfo& info,
                     const Eigen::VectorXd& times, const Eigen::MatrixXd& states) {
  std::vector<Eigen::Index> columns;
  for (const std::string& name : animation.states.names)
    columns.push_back(std::ranges::find(info.states, name, &models::StateInfo::name) - info.states.begin());
  models::PoseTrack track(limits_of(animation));
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    const Eigen::VectorXd numbers = states(i, columns);
    track.add(times[i], animation.states.pose({numbers.data(), static_cast<std::size_t>(numbers.size())}));
  }
  const models::PoseKeys keys = track.keys();
  if (!keys.is_dense)
    throw NoResultError(
        "between two steps of the motion the body turns so far that it cannot be shown: give a smaller step");
  write_keys(path, animation, keys);
}

}  // namespace samara::apps
