#include "air/cloud_animation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "pictures/animation.h"
#include "samara/base/errors.h"
#include "samara/io/animated_scene.h"
#include "samara/models/stochastic/gust_layout.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

/// Columns of the states of the pose among all states of a model.
std::vector<Eigen::Index> columns_of(const models::PoseStates& states, const models::ModelInfo& info) {
  std::vector<Eigen::Index> columns;
  for (const std::string& name : states.names) {
    const auto found = std::ranges::find(info.states, name, &models::StateInfo::name);
    columns.push_back(found - info.states.begin());
  }
  return columns;
}

/// A kept trajectory as far as its frames go; of fewer than two there is nothing to animate.
io::AnimatedBody flight(const std::string& name, const Eigen::VectorXd& times, const Eigen::MatrixXd& kept,
                        const models::PoseStates& states, const std::vector<Eigen::Index>& columns) {
  const Eigen::MatrixXd values = kept(Eigen::all, columns);
  Eigen::Index frames = 0;
  while (frames < values.rows() && values.row(frames).allFinite()) ++frames;
  io::AnimatedBody body{.name = name,
                        .times = times.head(frames),
                        .positions = Eigen::Matrix3Xd(3, frames),
                        .rotations = Eigen::Matrix4Xd(4, frames)};
  for (Eigen::Index i = 0; i < frames; ++i) {
    const Eigen::VectorXd row = values.row(i).transpose();
    const models::BodyPose pose = states.pose({row.data(), static_cast<std::size_t>(row.size())});
    body.positions.col(i) = pose.p_WB;
    body.rotations.col(i) = pose.q_WB;
  }
  return body;
}

/// The turn of a body's state, in body axes [rad/s].
Eigen::Vector3d turn_of(const models::GustLayout& layout, const Eigen::VectorXd& state) {
  switch (layout.space()) {
    case models::GustLayout::Space::body:
      return state(layout.rotation());
    case models::GustLayout::Space::plane:
      // theta turns from x to z, about -y.
      return {0.0, -state[layout.rotation()[0]], 0.0};
    case models::GustLayout::Space::point:
      break;
  }
  return Eigen::Vector3d::Zero();
}

/// One more key at the landing, up to which the body turns as it did at its last frame.
/// @param last state of the model at the last key
void add_landing(io::AnimatedBody& body, const models::Landing& landing, const models::GustLayout& layout,
                 const Eigen::VectorXd& last) {
  const Eigen::Index frames = body.times.size();
  const double left = landing.t - body.times[frames - 1];
  if (!(left > 0.0)) return;
  const Eigen::Vector3d turn = left * turn_of(layout, last);
  const Eigen::Vector4d q = body.rotations.col(frames - 1);
  const Eigen::Quaterniond down =
      Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * Eigen::AngleAxisd(turn.norm(), turn.normalized());
  body.times.conservativeResize(frames + 1);
  body.positions.conservativeResize(Eigen::NoChange, frames + 1);
  body.rotations.conservativeResize(Eigen::NoChange, frames + 1);
  body.times[frames] = landing.t;
  body.positions.col(frames) = landing.position;
  body.rotations.col(frames) << down.w(), down.vec();
}

/// A quarter of how far keys are from what their neighbours say of them: where motions are smooth, so far are they
/// from the straight line and the even turn between two keys.
struct Coarseness {
  double angle = 0.0, distance = 0.0;  ///< rad, and the unit of lengths
};

Coarseness coarseness_of(const std::vector<io::AnimatedBody>& bodies) {
  Coarseness worst;
  for (const io::AnimatedBody& body : bodies) {
    for (Eigen::Index i = 1; i + 1 < body.times.size(); ++i) {
      const double share = (body.times[i] - body.times[i - 1]) / (body.times[i + 1] - body.times[i - 1]);
      const Eigen::Vector3d straight =
          (1.0 - share) * body.positions.col(i - 1) + share * body.positions.col(i + 1);
      worst.distance = std::max(worst.distance, 0.25 * (body.positions.col(i) - straight).norm());
      const auto quaternion = [&](Eigen::Index k) {
        const auto q = body.rotations.col(k);
        return Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
      };
      const Eigen::Quaterniond even = quaternion(i - 1).slerp(share, quaternion(i + 1));
      worst.angle = std::max(worst.angle, 0.25 * even.angularDistance(quaternion(i)));
    }
  }
  return worst;
}

void warn_of_coarse_frames(const std::vector<io::AnimatedBody>& bodies, double size) {
  const Coarseness worst = coarseness_of(bodies);
  const double degrees = worst.angle * 180.0 / std::numbers::pi;
  constexpr double kMostDegrees = 0.5, kMostOfSize = 1e-3;
  if (degrees <= kMostDegrees && worst.distance <= kMostOfSize * size) return;
  const double finer = std::sqrt(std::max(degrees / kMostDegrees, worst.distance / (kMostOfSize * size)));
  warn(
      fmt::format("between frames, players draw bodies up to {:.2g} degrees and {:.2g} of their size from "
                  "their motion; {:.2g} times as many --frames would do",
                  degrees, worst.distance / size, std::ceil(1.1 * finer)));
}

}  // namespace

void write_cloud_animation(const std::string& path, const CloudFile& file, const models::TriangleMesh& mesh) {
  const models::ModelInfo& info = file.model.model().info();
  const models::PoseStates states = animated_states(info);
  const std::vector<Eigen::Index> columns = columns_of(states, info);
  const models::GustLayout layout(file.model.model());
  io::AnimatedScene scene{
      .name = info.name, .vertices = mesh.vertices, .triangles = mesh.triangles, .bodies = {}};
  std::size_t left_out = 0;
  for (std::size_t n = 0; n < file.cloud.kept.size(); ++n) {
    const Eigen::MatrixXd& kept = file.cloud.kept[n];
    const long number = file.cloud.first + static_cast<long>(n);
    io::AnimatedBody body =
        flight(fmt::format("realisation {}", number), file.cloud.times, kept, states, columns);
    const Eigen::Index frames = body.times.size();
    if (frames < 2) {
      ++left_out;
      continue;
    }
    const auto landing =
        std::ranges::lower_bound(file.cloud.landings, number, {}, &models::Landing::realisation);
    if (landing != file.cloud.landings.end() && landing->realisation == number)
      add_landing(body, *landing, layout, kept.row(frames - 1).transpose());
    scene.bodies.push_back(std::move(body));
  }
  if (scene.bodies.empty())
    throw NoResultError("no flight has two frames: there is nothing to animate, more --frames were expected");
  if (left_out > 0) warn(fmt::format("{} flights end before their second frame, and are left out", left_out));
  warn_of_coarse_frames(scene.bodies, 2.0 * mesh.vertices.colwise().norm().maxCoeff());
  scene.notes = {{"model", info.name},
                 {"air", file.air},
                 {"seed", std::to_string(file.seed)},
                 {"integrator", "rk4"},
                 {"step", fmt::format("{} s", file.step)}};
  scene.parameters = file.model.fixed();
  io::write_scene(path, scene);
}

}  // namespace samara::apps
