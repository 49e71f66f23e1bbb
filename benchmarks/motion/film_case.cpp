// Leaves as a film: how far what players put between keys is from the motion, and what the Khronos validator says.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "motion/cases.h"
#include "samara/io/animated_scene.h"
#include "samara/io/atomic_file.h"
#include "samara/models/bodies/pose_keys.h"
#include "samara/models/bodies/shown_body.h"
#include "samara/motion/bodies/bodies.h"

namespace samara::benchmarks::motion_cases {

namespace {

constexpr const char* kFilm = "glb";
constexpr Eigen::Index kLeaves = 100;
/// Looks a second of the example, and steps from look to look, at which the film is compared with the motion.
constexpr double kLooks = 960.0;
constexpr int kBetween = 4;

struct Film {
  std::vector<models::PoseKeys> keys;
  std::vector<std::vector<models::BodyPose>> motion;  ///< per leaf, kBetween times as many
};

Film fall(const motion::NextPieces& pieces, double length, int looks) {
  motion::Bodies leaves(pieces, kLeaves, {.step = 1.0 / (kLooks * kBetween), .seed = 7});
  for (Eigen::Index n = 0; n < kLeaves; ++n) leaves.release(n, {0.0, 0.0, 0.0}, 2.4 * static_cast<double>(n));
  std::vector<models::PoseTrack> tracks(kLeaves, models::PoseTrack({.distance = 8e-4 * length}));
  Film film;
  film.motion.resize(kLeaves);
  std::vector<double> positions(3 * kLeaves), rotations(4 * kLeaves);
  for (int step = 0; step <= looks * kBetween; ++step) {
    if (step > 0) leaves.advance(1.0 / (kLooks * kBetween));
    leaves.read_poses(positions, rotations);
    for (std::size_t n = 0; n < tracks.size(); ++n) {
      const models::BodyPose pose = {Eigen::Vector3d(&positions[3 * n]), Eigen::Vector4d(&rotations[4 * n])};
      film.motion[n].push_back(pose);
      if (step % kBetween == 0) tracks[n].add(step / (kLooks * kBetween), pose);
    }
  }
  for (const models::PoseTrack& track : tracks) film.keys.push_back(track.keys());
  return film;
}

Eigen::Quaternionf rotation_of(const models::BodyPose& pose) {
  return Eigen::Quaternionf(pose.q_WB.cast<float>()[0], pose.q_WB.cast<float>()[1],
                            pose.q_WB.cast<float>()[2], pose.q_WB.cast<float>()[3]);
}

/// Of one leaf, in single precision, as players have it: the largest angle [rad] and distance [m].
std::pair<double, double> worst_of(const models::PoseKeys& keys,
                                   const std::vector<models::BodyPose>& motion) {
  double angle = 0.0, distance = 0.0;
  std::size_t last = 0;
  for (std::size_t step = 0; step < motion.size(); ++step) {
    const double t = static_cast<double>(step) / (kLooks * kBetween);
    while (last + 2 < keys.times.size() && keys.times[last + 1] < t) ++last;
    const models::BodyPose &from = keys.poses[last], &to = keys.poses[last + 1];
    const auto share = static_cast<float>((t - keys.times[last]) / (keys.times[last + 1] - keys.times[last]));
    const Eigen::Vector3f place = (1.0F - share) * from.p_WB.cast<float>() + share * to.p_WB.cast<float>();
    distance = std::max(distance, (place.cast<double>() - motion[step].p_WB).norm());
    const Eigen::Vector4d& q = motion[step].q_WB;
    const Eigen::Quaterniond shown =
        rotation_of(from).slerp(share, rotation_of(to)).cast<double>().normalized();
    angle = std::max(angle, shown.angularDistance(Eigen::Quaterniond(q[0], q[1], q[2], q[3])));
  }
  return {angle, distance};
}

/// What the Khronos validator counts, where SAMARA_NODE_MODULES leads to it: errors, warnings.
bool validate(const std::filesystem::path& file, int& errors, int& warnings) {
  const char* modules = std::getenv("SAMARA_NODE_MODULES");
  if (modules == nullptr || !std::filesystem::exists(std::filesystem::path(modules) / "gltf-validator"))
    return false;
  const std::string command = fmt::format(
      "node -e \"require(process.argv[2] + '/gltf-validator').validateBytes(new "
      "Uint8Array(require('fs').readFileSync(process.argv[1]))).then((r) => console.log(r.issues.numErrors, "
      "r.issues.numWarnings))\" '{}' '{}'",
      file.string(), modules);
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return false;
  const bool is_read = std::fscanf(pipe, "%d %d", &errors, &warnings) == 2;
  return pclose(pipe) == 0 && is_read;
}

}  // namespace

void run_films(const Options& options) {
  if (!options.wants(kFilm)) return;
  const motion::NextPieces pieces(motion::build_database(
      motion::run_sweep(
          motion::read_sweep_plan(std::filesystem::path(SAMARA_EXAMPLES_DIR) / "leaves" / "leaf.toml"))
          .sweep));
  const auto& fixed = pieces.database().fixed;
  const double length = 2.0 * fixed.at("a");
  const Film film = fall(pieces, length, static_cast<int>(options.quick ? 0.5 * kLooks : 2.0 * kLooks));
  const models::TriangleMesh mesh =
      models::shown_shape("ellipsoid", std::array{fixed.at("a"), fixed.at("b"), fixed.at("c")});
  io::AnimatedScene scene{
      .name = "leaves", .vertices = mesh.vertices, .triangles = mesh.triangles, .bodies = {}};
  double angle = 0.0, distance = 0.0;
  std::size_t keys = 0;
  for (std::size_t n = 0; n < film.keys.size(); ++n) {
    const models::PoseKeys& track = film.keys[n];
    const auto [turned, moved] = worst_of(track, film.motion[n]);
    angle = std::max(angle, turned);
    distance = std::max(distance, moved);
    keys += track.times.size();
    const auto count = static_cast<Eigen::Index>(track.times.size());
    io::AnimatedBody body{fmt::format("leaf {}", n),
                          Eigen::Map<const Eigen::VectorXd>(track.times.data(), count),
                          Eigen::Matrix3Xd(3, count), Eigen::Matrix4Xd(4, count)};
    for (Eigen::Index k = 0; k < count; ++k) {
      body.positions.col(k) = track.poses[static_cast<std::size_t>(k)].p_WB;
      body.rotations.col(k) = track.poses[static_cast<std::size_t>(k)].q_WB;
    }
    scene.bodies.push_back(std::move(body));
  }
  std::cerr << fmt::format("{}: {:.1f} keys a second and leaf\n", kFilm,
                           static_cast<double>(keys) / static_cast<double>(kLeaves) /
                               (static_cast<double>(film.motion[0].size() - 1) / (kLooks * kBetween)));
  print({kMotion, kFilm, "slerp_error", 180.0 / std::numbers::pi * angle, "deg"});
  print({kMotion, kFilm, "place_error", distance / length, "l"});
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / fmt::format("samara_leaves_{}.glb", std::rand());
  io::write_text_atomically(file, io::format_glb(scene));
  int errors = 0, warnings = 0;
  if (validate(file, errors, warnings)) {
    print({kMotion, kFilm, "errors", static_cast<double>(errors), "1"});
    print({kMotion, kFilm, "warnings", static_cast<double>(warnings), "1"});
  }
  std::filesystem::remove(file);
}

}  // namespace samara::benchmarks::motion_cases
