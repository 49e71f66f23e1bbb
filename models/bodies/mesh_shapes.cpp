#include "samara/models/bodies/mesh_shapes.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/bodies/size_check.h"

namespace samara::models {

namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::Vector3i;
using std::numbers::pi;

struct MeshBuilder {
  std::vector<Vector3d> vertices;
  std::vector<Vector3i> triangles;

  int add(const Vector3d& p) {
    vertices.push_back(p);
    return static_cast<int>(vertices.size()) - 1;
  }
  /// Counter-clockwise, or the other way round.
  void add(int p, int q, int r, bool turned = false) {
    triangles.push_back(turned ? Vector3i(p, r, q) : Vector3i(p, q, r));
  }
  TriangleMesh mesh() const {
    TriangleMesh result;
    result.vertices.resize(3, static_cast<Index>(vertices.size()));
    result.triangles.resize(3, static_cast<Index>(triangles.size()));
    for (std::size_t i = 0; i < vertices.size(); ++i)
      result.vertices.col(static_cast<Index>(i)) = vertices[i];
    for (std::size_t i = 0; i < triangles.size(); ++i)
      result.triangles.col(static_cast<Index>(i)) = triangles[i];
    return result;
  }
};

void require_at_least(int value, int least, const char* what, const char* where) {
  if (value < least)
    throw ArgumentError(fmt::format("{}: {} is {}; at least {} expected", where, what, value, least));
}

TriangleMesh stretched(TriangleMesh sphere, const Vector3d& semi_axes, Placement placement) {
  double factor = 1.0;
  if (placement == Placement::equal_volume) factor = std::cbrt(4.0 / 3.0 * pi / enclosed_volume(sphere));
  sphere.vertices = (factor * semi_axes).asDiagonal() * sphere.vertices;
  return sphere;
}

/// Ring k of the half sphere z > 0 (or z < 0): returns the index of its first corner.
int add_ring(MeshBuilder& builder, int k, int rings, int sectors, double side) {
  const double theta = 0.5 * pi * k / rings;
  const double z = k == rings ? 0.0 : side * std::cos(theta);
  const int corners = k == 0 ? 1 : sectors * k;
  const int first = static_cast<int>(builder.vertices.size());
  for (int i = 0; i < corners; ++i) {
    const double phi = 2.0 * pi * i / corners;
    builder.add({std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), z});
  }
  return first;
}

/// Triangles between ring k-1 and ring k of one half sphere.
void add_band(MeshBuilder& builder, int inner, int outer, int k, int sectors, bool turned) {
  const int inner_corners = std::max(1, sectors * (k - 1)), outer_corners = sectors * k;
  for (int sector = 0; sector < sectors; ++sector) {
    for (int i = 0; i < k; ++i) {
      const int p = inner + (sector * (k - 1) + i) % inner_corners;
      const int q = outer + sector * k + i;
      const int r = outer + (sector * k + i + 1) % outer_corners;
      builder.add(p, q, r, turned);
      if (i < k - 1) builder.add(p, r, inner + (sector * (k - 1) + i + 1) % inner_corners, turned);
    }
  }
}

/// Corners of the icosahedron on the unit sphere and its faces.
struct Icosahedron {
  std::array<Vector3d, 12> corners;
  std::array<Vector3i, 20> faces;

  Icosahedron() {
    const double g = std::numbers::phi;
    corners = {Vector3d(-1, g, 0), {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
               {0, -1, -g},        {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    faces = {Vector3i(0, 11, 5), {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
             {11, 10, 2},        {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
             {3, 8, 9},          {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (Vector3d& corner : corners) corner.normalize();
  }
};

/// Position of node i of 0..n on [-1/2, 1/2], denser towards the ends.
double chebyshev(int i, int n) {
  return -0.5 * std::cos(pi * i / n);
}

/// Corners of a box's grid by their three indices.
class BoxGrid {
 public:
  BoxGrid(const Vector3d& sides, const std::array<int, 3>& cells) : sides_(sides), cells_(cells) {}

  int corner(const std::array<int, 3>& index) {
    const auto [entry, is_new] = known_.try_emplace(index, static_cast<int>(builder_.vertices.size()));
    if (is_new) {
      const Vector3d p(chebyshev(index[0], cells_[0]), chebyshev(index[1], cells_[1]),
                       chebyshev(index[2], cells_[2]));
      builder_.add(sides_.cwiseProduct(p));
    }
    return entry->second;
  }

  /// Both faces normal to an axis. Diagonals of cells run towards the middle, so that the mesh keeps the
  /// symmetries of the box.
  void add_faces(int axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto cu = static_cast<std::size_t>(u), cv = static_cast<std::size_t>(v);
    const auto ca = static_cast<std::size_t>(axis);
    for (const bool low : {true, false}) {
      for (int i = 0; i < cells_[cu]; ++i) {
        for (int j = 0; j < cells_[cv]; ++j) {
          std::array<int, 3> at{};
          at[ca] = low ? 0 : cells_[ca];
          const auto node = [&](int di, int dj) {
            at[cu] = i + di;
            at[cv] = j + dj;
            return corner(at);
          };
          const int p = node(0, 0), q = node(1, 0), r = node(1, 1), s = node(0, 1);
          if ((2 * i < cells_[cu]) == (2 * j < cells_[cv])) {
            builder_.add(p, q, r, low);
            builder_.add(p, r, s, low);
          } else {
            builder_.add(p, q, s, low);
            builder_.add(q, r, s, low);
          }
        }
      }
    }
  }
  TriangleMesh mesh() const { return builder_.mesh(); }

 private:
  Vector3d sides_;
  std::array<int, 3> cells_;
  MeshBuilder builder_;
  std::map<std::array<int, 3>, int> known_;
};

}  // namespace

TriangleMesh ellipsoid_mesh(const Vector3d& semi_axes, int rings, int sectors, Placement placement) {
  require_sizes(semi_axes, "semi-axis along", "ellipsoid_mesh");
  require_at_least(rings, 1, "number of rings", "ellipsoid_mesh");
  require_at_least(sectors, 3, "number of sectors", "ellipsoid_mesh");
  MeshBuilder builder;
  std::vector<int> upper, lower;
  for (int k = 0; k <= rings; ++k) upper.push_back(add_ring(builder, k, rings, sectors, 1.0));
  for (int k = 0; k < rings; ++k) lower.push_back(add_ring(builder, k, rings, sectors, -1.0));
  lower.push_back(upper.back());
  for (std::size_t k = 1; k < upper.size(); ++k) {
    add_band(builder, upper[k - 1], upper[k], static_cast<int>(k), sectors, false);
    add_band(builder, lower[k - 1], lower[k], static_cast<int>(k), sectors, true);
  }
  return stretched(builder.mesh(), semi_axes, placement);
}

TriangleMesh icosahedral_ellipsoid_mesh(const Vector3d& semi_axes, int divisions, Placement placement) {
  require_sizes(semi_axes, "semi-axis along", "icosahedral_ellipsoid_mesh");
  require_at_least(divisions, 1, "number of divisions", "icosahedral_ellipsoid_mesh");
  const Icosahedron solid;
  MeshBuilder builder;
  // A corner on an edge belongs to two faces: it is known by the weights of the solid's corners.
  std::map<std::array<std::pair<int, int>, 3>, int> known;
  const int n = divisions;
  for (const Vector3i& face : solid.faces) {
    const auto corner = [&](int i, int j) {
      std::array<std::pair<int, int>, 3> weights = {
          std::pair(face[0], n - i - j), {face[1], i}, {face[2], j}};
      for (auto& weight : weights) {
        if (weight.second == 0) weight = {-1, 0};
      }
      std::sort(weights.begin(), weights.end());
      const auto [entry, is_new] = known.try_emplace(weights, static_cast<int>(builder.vertices.size()));
      if (is_new) {
        Vector3d p = Vector3d::Zero();
        for (const auto& [at, weight] : weights) {
          if (weight > 0) p += weight * solid.corners[static_cast<std::size_t>(at)];
        }
        builder.add(p.normalized());
      }
      return entry->second;
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        builder.add(corner(i, j), corner(i + 1, j), corner(i, j + 1));
        if (i + j < n - 1) builder.add(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
      }
    }
  }
  return stretched(builder.mesh(), semi_axes, placement);
}

TriangleMesh box_mesh(const Vector3d& sides, int nx, int ny, int nz) {
  require_sizes(sides, "side along", "box_mesh");
  for (const int count : {nx, ny, nz})
    require_at_least(count, 1, "number of rectangles or layers", "box_mesh");
  BoxGrid grid(sides, {nx, ny, nz});
  for (int axis = 0; axis < 3; ++axis) grid.add_faces(axis);
  return grid.mesh();
}

}  // namespace samara::models
