#include "samara/models/bodies/mesh_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <unordered_map>
#include <vector>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/bodies/ply_check.h"

namespace samara::models {

namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::Vector3i;

struct Soup {
  std::vector<Vector3d> vertices;
  std::vector<Vector3i> triangles;
};

/// In small letters.
std::string known_ending(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  if (ending != ".obj" && ending != ".stl" && ending != ".ply") {
    throw InputError(path, fmt::format("the ending \"{}\" is not one of .obj, .stl, .ply", ending));
  }
  return ending;
}

/// Later steps trust the indices, and take a face without any for a polygon.
void require_indices(const std::string& path, const aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      if (mesh.mFaces[i].mNumIndices == 0) throw InputError(path, fmt::format("face {} has no corners", i));
      for (unsigned k = 0; k < mesh.mFaces[i].mNumIndices; ++k) {
        if (mesh.mFaces[i].mIndices[k] < mesh.mNumVertices) continue;
        throw InputError(path, fmt::format("face {} names corner {} of {}", i, mesh.mFaces[i].mIndices[k],
                                           mesh.mNumVertices));
      }
    }
  }
}

Soup import(const std::string& path) {
  const std::string ending = known_ending(path);
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path, "there is no such file");
  if (ending == ".ply") require_complete_ply(path);
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, 0);
  if (scene != nullptr) {
    require_indices(path, *scene);
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate | aiProcess_PreTransformVertices);
  }
  if (scene == nullptr)
    throw InputError(path, fmt::format("no mesh can be read: {}", importer.GetErrorString()));
  Soup soup;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    const auto first = static_cast<int>(soup.vertices.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& p = mesh.mVertices[i];
      soup.vertices.emplace_back(p.x, p.y, p.z);
      if (!soup.vertices.back().allFinite()) {
        throw InputError(path, fmt::format("corner {} of the mesh is not finite", soup.vertices.size() - 1));
      }
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices != 3) continue;  // points and lines enclose nothing
      soup.triangles.push_back(Vector3i::Constant(first) + Vector3i(static_cast<int>(face.mIndices[0]),
                                                                    static_cast<int>(face.mIndices[1]),
                                                                    static_cast<int>(face.mIndices[2])));
    }
  }
  if (soup.triangles.empty()) throw InputError(path, "it holds no triangles");
  return soup;
}

/// Corners by cells as large as the tolerance: those within it lie in the same cell or one next to it.
class CornerMerger {
 public:
  CornerMerger(const Vector3d& low, double tolerance) : low_(low), tolerance_(tolerance) {}

  int number_of(const Vector3d& p) {
    std::array<std::int64_t, 3> cell{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<Index>(k);
      cell[k] = tolerance_ > 0.0 ? static_cast<std::int64_t>(std::floor((p[i] - low_[i]) / tolerance_))
                                 : static_cast<std::int64_t>(std::hash<double>{}(p[i] + 0.0));
    }
    const int known = find(p, cell);
    if (known >= 0) return known;
    corners_.push_back(p);
    const auto number = static_cast<int>(corners_.size()) - 1;
    cells_[hash(cell)].push_back(number);
    return number;
  }
  const std::vector<Vector3d>& corners() const { return corners_; }

 private:
  int find(const Vector3d& p, const std::array<std::int64_t, 3>& cell) const {
    const std::int64_t reach = tolerance_ > 0.0 ? 1 : 0;
    for (std::int64_t i = -reach; i <= reach; ++i) {
      for (std::int64_t j = -reach; j <= reach; ++j) {
        for (std::int64_t k = -reach; k <= reach; ++k) {
          const auto list = cells_.find(hash({cell[0] + i, cell[1] + j, cell[2] + k}));
          if (list == cells_.end()) continue;
          for (const int number : list->second) {
            if ((corners_[static_cast<std::size_t>(number)] - p).norm() <= tolerance_) return number;
          }
        }
      }
    }
    return -1;
  }
  static std::uint64_t hash(const std::array<std::int64_t, 3>& cell) {
    std::uint64_t h = 0;
    for (const std::int64_t i : cell)
      h = (h ^ static_cast<std::uint64_t>(i)) * 0x9E3779B97F4A7C15u + (h >> 29);
    return h;
  }

  Vector3d low_;
  double tolerance_;
  std::vector<Vector3d> corners_;
  std::unordered_map<std::uint64_t, std::vector<int>> cells_;
};

/// Corners that no triangle names are left out: they would count for the size.
TriangleMesh merged(const Soup& soup, double metres_per_unit, double merge_tolerance) {
  std::vector<char> is_named(soup.vertices.size(), 0);
  for (const Vector3i& t : soup.triangles) {
    for (const int corner : t) is_named[static_cast<std::size_t>(corner)] = 1;
  }
  Vector3d low = soup.vertices[static_cast<std::size_t>(soup.triangles.front()[0])], high = low;
  for (std::size_t i = 0; i < soup.vertices.size(); ++i) {
    if (!is_named[i]) continue;
    low = low.cwiseMin(soup.vertices[i]);
    high = high.cwiseMax(soup.vertices[i]);
  }
  CornerMerger merger(low, merge_tolerance * (high - low).norm());
  std::vector<int> number(soup.vertices.size(), -1);
  for (std::size_t i = 0; i < soup.vertices.size(); ++i) {
    if (is_named[i]) number[i] = merger.number_of(soup.vertices[i]);
  }
  std::vector<Vector3i> triangles;
  for (const Vector3i& t : soup.triangles) {
    Vector3i corners;
    for (int k = 0; k < 3; ++k) corners[k] = number[static_cast<std::size_t>(t[k])];
    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0])
      triangles.push_back(corners);
  }
  TriangleMesh mesh;
  mesh.vertices.resize(3, static_cast<Index>(merger.corners().size()));
  for (std::size_t i = 0; i < merger.corners().size(); ++i) {
    mesh.vertices.col(static_cast<Index>(i)) = metres_per_unit * merger.corners()[i];
  }
  mesh.triangles.resize(3, static_cast<Index>(triangles.size()));
  for (std::size_t i = 0; i < triangles.size(); ++i) mesh.triangles.col(static_cast<Index>(i)) = triangles[i];
  return mesh;
}

}  // namespace

TriangleMesh read_mesh(const std::string& path, double metres_per_unit, const MeshFileOptions& options) {
  require_positive(metres_per_unit, "metres_per_unit", "read_mesh");
  if (!(options.merge_tolerance >= 0.0 && options.merge_tolerance <= 0.1)) {
    throw ArgumentError(fmt::format("read_mesh: merge_tolerance is {}; a number in [0, 0.1] expected",
                                    options.merge_tolerance));
  }
  // Its corners are counted in steps of the tolerance, by whole numbers that a double holds.
  constexpr double kLeastTolerance = 0x1p-53;
  if (options.merge_tolerance > 0.0 && options.merge_tolerance < kLeastTolerance) {
    throw ArgumentError(fmt::format("read_mesh: merge_tolerance is {}; 0 or at least {} expected",
                                    options.merge_tolerance, kLeastTolerance));
  }
  TriangleMesh mesh = merged(import(path), metres_per_unit, options.merge_tolerance);
  if (mesh.triangles.cols() == 0) throw InputError(path, "none of its triangles has an area");
  try {
    if (options.turn_outward) mesh = oriented_outward(std::move(mesh));
    if (options.closed) require_closed(mesh);
  } catch (const ArgumentError& error) {
    throw InputError(path, error.what());
  }
  return mesh;
}

}  // namespace samara::models
