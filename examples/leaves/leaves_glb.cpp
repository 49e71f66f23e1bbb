/// A thousand leaves as one film for Blender and others:
///
///   samara sweep examples/leaves/leaf.toml -o sweep.h5
///   samara database sweep.h5 -o leaf.h5
///   leaves_glb leaf.h5 leaves.glb
///
/// Each leaf is one solution of the equations of motion whose coefficients change at its events; nothing is blended.
#include <cstdio>
#include <exception>
#include <string>

#include "samara/base/errors.h"
#include "samara/io/animated_scene.h"
#include "samara/io/atomic_file.h"
#include "samara/models/bodies/pose_keys.h"
#include "samara/motion/bodies/bodies.h"
#include "samara/motion/bodies/steady_wind.h"
#include "samara/motion/database/database_file.h"

using namespace samara;

namespace {

constexpr Eigen::Index kLeaves = 1000;
constexpr double kLooks =
    960.0;  // a second: of these poses those are kept that players need as keys

/// A flat leaf with a point at both ends, seen from both sides.
void add_mesh(double a, double b, io::AnimatedScene& scene) {
  scene.vertices.resize(3, 6);
  scene.vertices << -a, -0.4 * a, 0.5 * a, a, 0.5 * a, -0.4 * a, 0, b, 0.7 * b, 0, -0.7 * b, -b, 0,
      0, 0, 0, 0, 0;
  scene.triangles.resize(3, 8);
  // Four from above, and the same from below.
  scene.triangles << 0, 0, 0, 0, 0, 0, 0, 0, 5, 4, 3, 2, 4, 3, 2, 1, 4, 3, 2, 1, 5, 4, 3, 2;
}

/// Of each leaf until it rests. Keys are as dense as its turns ask for: what players put between two of them is within
/// 0.4 degrees and a thousandth of its length.
std::vector<models::PoseKeys> fall(const motion::NextPieces& pieces) {
  motion::BodiesOptions options;
  options.step = 1.0 / kLooks;
  options.ground = 0.0;
  options.wind = motion::steady_wind({0.3, 0.1, 0.0});
  options.seed = 7;
  motion::Bodies leaves(pieces, kLeaves, options);
  for (Eigen::Index n = 0; n < kLeaves; ++n)
    leaves.release(n, {0.1 * static_cast<double>(n % 40), 0.1 * static_cast<double>(n / 40), 2.0},
                   2.4 * static_cast<double>(n));
  const double length = 2.0 * pieces.database().fixed.at("a");
  std::vector<models::PoseTrack> tracks(kLeaves, models::PoseTrack({.distance = 8e-4 * length}));
  std::vector<double> positions(3 * kLeaves), rotations(4 * kLeaves);
  for (int look = 0; look < 30 * static_cast<int>(kLooks) && leaves.falling() > 0; ++look) {
    if (look > 0) leaves.advance(1.0 / kLooks);
    leaves.read_poses(positions, rotations);
    for (std::size_t n = 0; n < tracks.size(); ++n) {
      // One that rests had its last look when it came to rest.
      if (leaves.time(static_cast<Eigen::Index>(n)) < (look - 0.5) / kLooks) continue;
      tracks[n].add(look / kLooks,
                    {Eigen::Vector3d(&positions[3 * n]), Eigen::Vector4d(&rotations[4 * n])});
    }
  }
  std::vector<models::PoseKeys> keys;
  for (const models::PoseTrack& track : tracks) keys.push_back(track.keys());
  return keys;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: leaves_glb MOTIONS.h5 OUT.glb\n", stderr);
    return 2;
  }
  try {
    // 1. The motions of one leaf, and what can follow what.
    const motion::NextPieces pieces(motion::load_database(argv[1]));
    // 2. A thousand of them fall to the ground in a light wind.
    const std::vector<models::PoseKeys> tracks = fall(pieces);
    // 3. One mesh, a node each.
    io::AnimatedScene scene;
    scene.name = "leaves";
    add_mesh(pieces.database().fixed.at("a"), pieces.database().fixed.at("b"), scene);
    scene.notes = {{"model", pieces.database().model}, {"seed", "7"}};
    scene.parameters = pieces.database().fixed;
    std::size_t keys = 0;
    for (std::size_t n = 0; n < tracks.size(); ++n) {
      const models::PoseKeys& track = tracks[n];
      if (!track.is_dense) throw NoResultError("a leaf turns too fast for its looks");
      const auto count = static_cast<Eigen::Index>(track.times.size());
      keys += track.times.size();
      io::AnimatedBody body{"leaf " + std::to_string(n),
                            Eigen::Map<const Eigen::VectorXd>(track.times.data(), count),
                            Eigen::Matrix3Xd(3, count), Eigen::Matrix4Xd(4, count)};
      for (Eigen::Index k = 0; k < count; ++k) {
        body.positions.col(k) = track.poses[static_cast<std::size_t>(k)].p_WB;
        body.rotations.col(k) = track.poses[static_cast<std::size_t>(k)].q_WB;
      }
      scene.bodies.push_back(std::move(body));
    }
    io::write_text_atomically(argv[2], io::format_glb(scene));
    std::printf("%zu leaves with %zu keys in %s\n", tracks.size(), keys, argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "leaves_glb: %s\n", error.what());
    return 1;
  }
  return 0;
}
