#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

/// Rigid motions as files for viewers and animation programs: binary glTF 2.0 (.glb), and OpenUSD as text (.usda). One
/// mesh, a node for each body, linear keys. References: Khronos Group, glTF 2.0 Specification,
/// https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html; Pixar, Universal Scene Description, usda file format.
namespace samara::io {

/// One body that moves. Players go linearly between positions, and by the shorter great circle between rotations.
struct AnimatedBody {
  std::string name;
  Eigen::VectorXd times;       ///< s, increasing, at least two
  Eigen::Matrix3Xd positions;  ///< of the mesh's origin, in a world with z up
  Eigen::Matrix4Xd rotations;  ///< unit quaternions (w, x, y, z), body to world; their signs are of no matter
};

struct AnimatedScene {
  std::string name;
  Eigen::Matrix3Xd vertices;   ///< of the mesh of all bodies, in body axes
  Eigen::Matrix3Xi triangles;  ///< numbers of corners, counter-clockwise from outside; both sides are seen
  std::vector<AnimatedBody> bodies;
  std::vector<std::pair<std::string, std::string>> notes = {};  ///< of the scene: what it was made from
  std::map<std::string, double> parameters = {};                ///< of the motion, SI
};

/// The bytes of a .glb file: y up, as glTF has it (x stays, z becomes y), single floats, times from the first key on.
/// Keys that no single float tells apart become one. Notes and parameters stand in `extras` of the scene, and
/// `start`, the time of a body's first key, in those of its node.
/// @throws ArgumentError if there is no body, triangle or corner, sizes do not match, a corner has no such number,
/// times do not increase, a quaternion is not of length one, or a number is not finite as a single float.
std::string format_glb(const AnimatedScene& scene);

/// The text of a .usda file: z up, in double precision, 24 time codes a second.
/// @throws ArgumentError likewise
std::string format_usda(const AnimatedScene& scene);

/// Whether a file of this name is one of these, by its ending, which may stand in capitals.
bool is_scene_name(const std::filesystem::path& path);

/// For whoever writes something else under all other names.
/// @throws ArgumentError for the ending of a scene that is not written: .gltf, .fbx, .usd, .usdz
void check_scene_name(const std::filesystem::path& path);

/// In the format that the ending says.
/// @throws ArgumentError likewise, for another ending, and if the file cannot be written
void write_scene(const std::filesystem::path& path, const AnimatedScene& scene);

}  // namespace samara::io
