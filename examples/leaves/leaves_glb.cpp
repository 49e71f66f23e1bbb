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

#include "samara/io/atomic_file.h"
#include "samara/io/glb.h"
#include "samara/motion/bodies/bodies.h"
#include "samara/motion/bodies/steady_wind.h"
#include "samara/motion/database/database_file.h"

using namespace samara;

namespace {

constexpr Eigen::Index kLeaves = 1000;
constexpr double kKeys = 120.0;  // a second: between two of them no leaf turns more than 20 degrees

/// Poses of one leaf until it rests.
struct Track {
  std::vector<double> times, positions, rotations;
  bool is_done = false;
};

/// A flat leaf with a point at both ends, seen from both sides.
void add_mesh(double a, double b, io::AnimatedScene& scene) {
  scene.vertices.resize(3, 6);
  scene.vertices << -a, -0.4 * a, 0.5 * a, a, 0.5 * a, -0.4 * a, 0, b, 0.7 * b, 0, -0.7 * b, -b, 0, 0, 0, 0,
      0, 0;
  scene.triangles.resize(3, 8);
  // Four from above, and the same from below.
  scene.triangles << 0, 0, 0, 0, 0, 0, 0, 0, 5, 4, 3, 2, 4, 3, 2, 1, 4, 3, 2, 1, 5, 4, 3, 2;
}

std::vector<Track> fall(const motion::NextPieces& pieces) {
  motion::BodiesOptions options;
  options.step = 1.0 / 240.0;
  options.ground = 0.0;
  options.wind = motion::steady_wind({0.3, 0.1, 0.0});
  options.seed = 7;
  motion::Bodies leaves(pieces, kLeaves, options);
  for (Eigen::Index n = 0; n < kLeaves; ++n)
    leaves.release(n, {0.1 * static_cast<double>(n % 40), 0.1 * static_cast<double>(n / 40), 2.0},
                   2.4 * static_cast<double>(n));
  std::vector<Track> tracks(kLeaves);
  std::vector<double> positions(3 * kLeaves), rotations(4 * kLeaves);
  for (int key = 0; key < 3600; ++key) {
    leaves.read_poses(positions, rotations);
    for (std::size_t n = 0; n < tracks.size(); ++n) {
      Track& track = tracks[n];
      if (track.is_done) continue;
      track.times.push_back(key / kKeys);
      track.positions.insert(track.positions.end(), &positions[3 * n], &positions[3 * n] + 3);
      track.rotations.insert(track.rotations.end(), &rotations[4 * n], &rotations[4 * n] + 4);
      track.is_done = leaves.status(static_cast<Eigen::Index>(n)) != motion::BodyStatus::falling;
    }
    if (leaves.falling() == 0) break;
    leaves.advance(1.0 / kKeys);
  }
  return tracks;
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
    const std::vector<Track> tracks = fall(pieces);
    // 3. One mesh, a node each.
    io::AnimatedScene scene;
    scene.name = "leaves";
    add_mesh(pieces.database().fixed.at("a"), pieces.database().fixed.at("b"), scene);
    scene.notes = {{"model", pieces.database().model}, {"seed", "7"}};
    scene.parameters = pieces.database().fixed;
    std::size_t keys = 0;
    for (std::size_t n = 0; n < tracks.size(); ++n) {
      const auto count = static_cast<Eigen::Index>(tracks[n].times.size());
      keys += tracks[n].times.size();
      scene.bodies.push_back({"leaf " + std::to_string(n),
                              Eigen::Map<const Eigen::VectorXd>(tracks[n].times.data(), count),
                              Eigen::Map<const Eigen::Matrix3Xd>(tracks[n].positions.data(), 3, count),
                              Eigen::Map<const Eigen::Matrix4Xd>(tracks[n].rotations.data(), 4, count)});
    }
    io::write_text_atomically(argv[2], io::format_glb(scene));
    std::printf("%zu leaves with %zu keys in %s\n", tracks.size(), keys, argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "leaves_glb: %s\n", error.what());
    return 1;
  }
  return 0;
}
