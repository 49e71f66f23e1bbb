#include "samara/models/bodies/triangle_mesh.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::models {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Sum of squares of edges and so on see the mesh from its first corner: no cancellation far from the origin.
Vector3d origin_of(const TriangleMesh& mesh) {
  return mesh.vertices.col(mesh.triangles(0, 0));
}

double size_of(const TriangleMesh& mesh) {
  return (mesh.vertices.rowwise().maxCoeff() - mesh.vertices.rowwise().minCoeff()).norm();
}

std::string place(const Vector3d& p) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x(), p.y(), p.z());
}

[[noreturn]] void refuse(const std::string& sentence) {
  throw ArgumentError(fmt::format("triangle mesh: {}", sentence));
}

void require_numbers(const TriangleMesh& mesh) {
  if (mesh.triangles.cols() == 0) refuse("it has no triangles");
  for (Index i = 0; i < mesh.vertices.cols(); ++i) {
    if (!mesh.vertices.col(i).allFinite()) {
      refuse(fmt::format("corner {} is {}: not finite", i, place(mesh.vertices.col(i))));
    }
  }
  for (Index i = 0; i < mesh.triangles.cols(); ++i) {
    for (int k = 0; k < 3; ++k) {
      if (mesh.triangles(k, i) < 0 || mesh.triangles(k, i) >= mesh.vertices.cols()) {
        refuse(
            fmt::format("triangle {} names corner {} of {}", i, mesh.triangles(k, i), mesh.vertices.cols()));
      }
    }
  }
}

void require_areas(const TriangleMesh& mesh) {
  const double least_height = 1e-12 * size_of(mesh);
  for (Index i = 0; i < mesh.triangles.cols(); ++i) {
    const Vector3d p = mesh.vertices.col(mesh.triangles(0, i));
    const Vector3d q = mesh.vertices.col(mesh.triangles(1, i));
    const Vector3d r = mesh.vertices.col(mesh.triangles(2, i));
    const double longest = std::max({(q - p).norm(), (r - q).norm(), (p - r).norm()});
    if (!((q - p).cross(r - p).norm() > least_height * longest)) {
      refuse(fmt::format("triangle {} at {} has no area", i, place(p)));
    }
  }
}

/// A side of a triangle, from its lower to its higher corner.
struct Side {
  int from, to;
  bool forward;  ///< whether the triangle runs through it that way
  bool operator<(const Side& other) const { return std::tie(from, to) < std::tie(other.from, other.to); }
  bool same_edge(const Side& other) const { return from == other.from && to == other.to; }
};

std::vector<Side> sorted_sides(const TriangleMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(static_cast<std::size_t>(3 * mesh.triangles.cols()));
  for (Index i = 0; i < mesh.triangles.cols(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int p = mesh.triangles(k, i), q = mesh.triangles((k + 1) % 3, i);
      sides.push_back({std::min(p, q), std::max(p, q), p < q});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

void require_paired_sides(const TriangleMesh& mesh) {
  const std::vector<Side> sides = sorted_sides(mesh);
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i;
    while (end < sides.size() && sides[end].same_edge(sides[i])) ++end;
    const std::string edge = fmt::format("the edge between corners {} {} and {} {}", sides[i].from,
                                         place(mesh.vertices.col(sides[i].from)), sides[i].to,
                                         place(mesh.vertices.col(sides[i].to)));
    if (end - i == 1) refuse(fmt::format("it is not closed: {} belongs to one triangle only", edge));
    if (end - i > 2) refuse(fmt::format("{} belongs to {} triangles; two are expected", edge, end - i));
    if (sides[i].forward == sides[i + 1].forward) {
      refuse(fmt::format("the two triangles at {} are oriented differently", edge));
    }
    i = end;
  }
}

}  // namespace

double enclosed_volume(const TriangleMesh& mesh) {
  if (mesh.triangles.cols() == 0) return 0.0;
  const Vector3d origin = origin_of(mesh);
  double six_volumes = 0.0;
  for (Index i = 0; i < mesh.triangles.cols(); ++i) {
    const Vector3d p = mesh.vertices.col(mesh.triangles(0, i)) - origin;
    const Vector3d q = mesh.vertices.col(mesh.triangles(1, i)) - origin;
    const Vector3d r = mesh.vertices.col(mesh.triangles(2, i)) - origin;
    six_volumes += p.dot(q.cross(r));
  }
  return six_volumes / 6.0;
}

TriangleMesh oriented_outward(TriangleMesh mesh) {
  if (enclosed_volume(mesh) < 0.0) mesh.triangles.row(1).swap(mesh.triangles.row(2));
  return mesh;
}

void require_closed(const TriangleMesh& mesh) {
  require_numbers(mesh);
  require_areas(mesh);
  require_paired_sides(mesh);
  const double volume = enclosed_volume(mesh);
  const double size = size_of(mesh);
  if (std::abs(volume) < 1e-14 * size * size * size) {
    refuse(fmt::format("its volume is {:.3g} m^3 at a size of {:.3g} m: it encloses nothing", volume, size));
  }
  if (volume < 0.0) {
    refuse(fmt::format(
        "its volume is {:.6g} m^3: the surface is inside out; oriented_outward() turns it over", volume));
  }
}

}  // namespace samara::models
