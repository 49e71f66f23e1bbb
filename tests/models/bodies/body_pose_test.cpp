#include "samara/models/bodies/body_pose.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/models/bodies/pose_keys.h"
#include "samara/models/bodies/shown_body.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;

namespace {

constexpr double kPi = std::numbers::pi;

Eigen::Vector3d turned(const BodyPose& pose, const Eigen::Vector3d& v) {
  const Eigen::Vector4d& q = pose.q_WB;
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * v;
}

}  // namespace

TEST_CASE("the pose of a model is found by what its states are") {
  const auto kind = [](const char* model) {
    const auto states = pose_states_of(find_model(model)->info());
    return states ? static_cast<int>(states->kind) : -1;
  };
  using Kind = PoseStates::Kind;
  CHECK(kind("vertical_fall") == static_cast<int>(Kind::line));
  CHECK(kind("falling_plate") == static_cast<int>(Kind::plane));
  CHECK(kind("falling_plate_nd") == static_cast<int>(Kind::plane));
  CHECK(kind("sphere_flight") == static_cast<int>(Kind::point));
  CHECK(kind("immersed_body") == static_cast<int>(Kind::space));
  CHECK(kind("coupled_triple") == -1);
  CHECK(kind("constant_rate") == -1);
}

TEST_CASE("poses stand in a world with z up") {
  const PoseStates fall = *pose_states_of(find_model("vertical_fall")->info());
  CHECK(fall.pose(std::array{0.3}).p_WB.z() == -0.3);
  const PoseStates plane = *pose_states_of(find_model("falling_plate")->info());
  const BodyPose pose = plane.pose(std::array{1.0, 2.0, 0.4});
  CHECK(pose.p_WB == Eigen::Vector3d(1.0, 0.0, 2.0));
  // theta from world x to the chord, and the normal to its left.
  CHECK((turned(pose, Eigen::Vector3d::UnitX()) - Eigen::Vector3d(std::cos(0.4), 0.0, std::sin(0.4))).norm() <
        1e-15);
  CHECK(
      (turned(pose, Eigen::Vector3d::UnitZ()) - Eigen::Vector3d(-std::sin(0.4), 0.0, std::cos(0.4))).norm() <
      1e-15);
}

TEST_CASE("bodies that are drawn are closed and have the volume of their shapes") {
  const auto volume = [](const TriangleMesh& mesh) {
    require_closed(mesh);
    return enclosed_volume(mesh);
  };
  CHECK(volume(shown_shape("plate", std::array{2.0, 3.0, 0.5})) == Approx(3.0));
  CHECK(volume(shown_shape("disc", std::array{1.0, 0.5})) == Approx(0.5 * kPi).epsilon(0.01));
  CHECK(volume(shown_shape("ellipsoid", std::array{1.0, 2.0, 3.0})) == Approx(8.0 * kPi).epsilon(0.05));
  CHECK(volume(*shown_body({{"semi_chord", 0.1}, {"semi_thickness", 0.01}})) ==
        Approx(kPi * 0.1 * 0.01 * 0.2).epsilon(0.01));
  const TriangleMesh offset = *shown_body({{"chord", 2.0}, {"thickness", 0.1}, {"offset", 0.3}});
  CHECK(offset.vertices.row(0).minCoeff() == Approx(-1.3));
  CHECK_FALSE(shown_body({{"mass", 1.0}}));
  CHECK_THROWS_AS(shown_shape("disc", std::array{1.0}), samara::ArgumentError);
  CHECK_THROWS_AS(shown_shape("plate", std::array{1.0, -1.0, 1.0}), samara::ArgumentError);
}

TEST_CASE("keys are as dense as the motion needs, and no denser than a few times that") {
  // Ten turns in one second at an even rate, on a circle of the radius 1: the chord of an arc a is a^2/8 from it.
  const auto poses_at = [](const std::vector<double>& times) {
    std::vector<BodyPose> poses;
    for (const double t : times) {
      const double a = 20.0 * kPi * t;
      poses.push_back({{std::cos(a), 0.0, std::sin(a)}, {std::cos(0.5 * a), 0.0, -std::sin(0.5 * a), 0.0}});
    }
    return poses;
  };
  const PoseKeyLimits limits{.distance = 1e-3};
  const PoseKeys keys = dense_pose_keys(poses_at, 0.0, 1.0, limits);
  CHECK(keys.is_dense);
  const double least = 20.0 * kPi / std::sqrt(8e-3);
  CHECK(static_cast<double>(keys.times.size()) > least);
  CHECK(static_cast<double>(keys.times.size()) < 2.0 * least + 64.0);
  CHECK_FALSE(dense_pose_keys(poses_at, 0.0, 1.0, {.distance = 1e-3, .most = 100}).is_dense);
  CHECK_THROWS_AS(dense_pose_keys(poses_at, 1.0, 1.0, limits), samara::ArgumentError);
}

TEST_CASE("keys of a track keep all poses that were seen within the limits, and turns short") {
  // A body whose turns grow faster, up to five a second, on a wave.
  const auto pose_at = [](double t) {
    const double a = 5.0 * kPi * t * t;
    return BodyPose{{0.1 * std::sin(3.0 * t), 0.0, -t}, {std::cos(0.5 * a), std::sin(0.5 * a), 0.0, 0.0}};
  };
  const PoseKeyLimits limits{.distance = 1e-4};
  PoseTrack track(limits);
  for (int k = 0; k <= 1000; ++k) track.add(1e-3 * k, pose_at(1e-3 * k));
  const PoseKeys keys = track.keys();
  CHECK(track.seen() == 1001);
  CHECK(keys.is_dense);
  CHECK(keys.times.size() < 200);
  CHECK(keys.times.front() == 0.0);
  CHECK(keys.times.back() == 1.0);
  std::size_t last = 0;
  for (int k = 0; k <= 1000; ++k) {
    const double t = 1e-3 * k;
    while (last + 2 < keys.times.size() && keys.times[last + 1] < t) ++last;
    const BodyPose &from = keys.poses[last], &to = keys.poses[last + 1], pose = pose_at(t);
    const double share = (t - keys.times[last]) / (keys.times[last + 1] - keys.times[last]);
    CHECK((from.p_WB + share * (to.p_WB - from.p_WB) - pose.p_WB).norm() <= limits.distance);
    const Eigen::Quaterniond a(from.q_WB[0], from.q_WB[1], from.q_WB[2], from.q_WB[3]);
    const Eigen::Quaterniond b(to.q_WB[0], to.q_WB[1], to.q_WB[2], to.q_WB[3]);
    const Eigen::Quaterniond q(pose.q_WB[0], pose.q_WB[1], pose.q_WB[2], pose.q_WB[3]);
    CHECK(a.slerp(share, b).angularDistance(q) <= limits.angle + 1e-7);
    CHECK(a.angularDistance(b) <= limits.turn);
  }
  CHECK_THROWS_AS(track.add(1.0, pose_at(1.0)), samara::ArgumentError);
  track.add(1.3, pose_at(1.3));
  CHECK_FALSE(track.keys().is_dense);  // a third of a second without a look: 99 degrees the shorter way
}

TEST_CASE("a jump of a motion stands between two keys that single precision tells apart") {
  const auto poses_at = [](const std::vector<double>& times) {
    std::vector<BodyPose> poses;
    for (const double t : times) poses.push_back({{t, 0.0, t < 1.3 ? 0.0 : 0.01}, Eigen::Vector4d::UnitX()});
    return poses;
  };
  const PoseKeys keys = dense_pose_keys(poses_at, 1.0, 1.5, {.distance = 1e-4});
  CHECK(keys.is_dense);
  CHECK(keys.times.size() < 100);
  bool has_jump = false;
  for (std::size_t i = 1; i < keys.times.size(); ++i) {
    REQUIRE(static_cast<float>(keys.times[i] - 1.0) > static_cast<float>(keys.times[i - 1] - 1.0));
    const double step = keys.poses[i].p_WB.z() - keys.poses[i - 1].p_WB.z();
    CHECK((step == 0.0 || keys.times[i] - keys.times[i - 1] < 1e-6));
    has_jump = has_jump || step == 0.01;
  }
  CHECK(has_jump);
}
