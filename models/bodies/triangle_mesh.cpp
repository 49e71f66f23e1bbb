#include "samara/models/bodies/triangle_mesh.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Geometry>
#include <boost/pending/disjoint_sets.hpp>
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

/// Of the tetrahedron from the origin to a triangle.
double signed_volume(const TriangleMesh& mesh, Index triangle, const Vector3d& origin) {
  const Vector3d p = mesh.vertices.col(mesh.triangles(0, triangle)) - origin;
  const Vector3d q = mesh.vertices.col(mesh.triangles(1, triangle)) - origin;
  const Vector3d r = mesh.vertices.col(mesh.triangles(2, triangle)) - origin;
  return p.dot(q.cross(r)) / 6.0;
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

/// Integrals over the surface do not see an unused corner; extents and the equations at the corners would.
void require_used_corners(const TriangleMesh& mesh) {
  std::vector<bool> used(static_cast<std::size_t>(mesh.vertices.cols()), false);
  for (const int corner : mesh.triangles.reshaped()) used[static_cast<std::size_t>(corner)] = true;
  const auto unused = std::ranges::find(used, false);
  if (unused == used.end()) return;
  const Index i = unused - used.begin();
  refuse(fmt::format("corner {} {} belongs to no triangle; drop it", i, place(mesh.vertices.col(i))));
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
  int triangle;
  bool operator<(const Side& other) const { return std::tie(from, to) < std::tie(other.from, other.to); }
  bool same_edge(const Side& other) const { return from == other.from && to == other.to; }
};

std::vector<Side> sorted_sides(const TriangleMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(static_cast<std::size_t>(3 * mesh.triangles.cols()));
  for (Index i = 0; i < mesh.triangles.cols(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int p = mesh.triangles(k, i), q = mesh.triangles((k + 1) % 3, i);
      sides.push_back({std::min(p, q), std::max(p, q), p < q, static_cast<int>(i)});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

void require_paired_sides(const TriangleMesh& mesh, const std::vector<Side>& sides) {
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

/// What hangs together by edges.
struct Part {
  Index first = 0;      ///< its first triangle
  double volume = 0.0;  ///< [m^3]
  Eigen::AlignedBox3d box;
};

/// @param sides paired
std::vector<Part> parts_of(const TriangleMesh& mesh, const std::vector<Side>& sides) {
  const auto count = static_cast<std::size_t>(mesh.triangles.cols());
  boost::disjoint_sets_with_storage<> sets(count);
  for (std::size_t i = 0; i < count; ++i) sets.make_set(i);
  for (std::size_t i = 0; i < sides.size(); i += 2) {
    sets.union_set(static_cast<std::size_t>(sides[i].triangle),
                   static_cast<std::size_t>(sides[i + 1].triangle));
  }
  std::vector<Part> parts;
  std::vector<int> part_of(count, -1);  // by representative
  for (std::size_t i = 0; i < count; ++i) {
    int& number = part_of[sets.find_set(i)];
    if (number < 0) {
      number = static_cast<int>(parts.size());
      parts.push_back({.first = static_cast<Index>(i), .volume = 0.0, .box = {}});
    }
    Part& part = parts[static_cast<std::size_t>(number)];
    const Vector3d origin = mesh.vertices.col(mesh.triangles(0, part.first));
    part.volume += signed_volume(mesh, static_cast<Index>(i), origin);
    for (const int corner : mesh.triangles.col(static_cast<Index>(i))) {
      part.box.extend(mesh.vertices.col(corner));
    }
  }
  return parts;
}

/// Inside out is a part only as the wall of a cavity.
void require_oriented_parts(const TriangleMesh& mesh, const std::vector<Part>& parts, double no_volume) {
  const auto is_solid = [&](const Part& part) { return part.volume > no_volume; };
  if (std::ranges::none_of(parts, is_solid)) return;  // the whole is inside out, or nothing
  for (const Part& part : parts) {
    if (!(part.volume < -no_volume)) continue;
    const bool is_cavity = std::ranges::any_of(
        parts, [&](const Part& other) { return is_solid(other) && other.box.contains(part.box); });
    if (is_cavity) continue;
    refuse(fmt::format(
        "of its {} separate parts, that of triangle {} at {} is inside out (its volume is "
        "{:.6g} m^3) and lies within no other; turn its triangles over",
        parts.size(), part.first, place(mesh.vertices.col(mesh.triangles(0, part.first))), part.volume));
  }
}

/// Side k of a triangle is that from its corner k to the next.
struct TriangleSide {
  Index triangle = 0;
  int k = 0;
};

/// Of the first `count` triangles. Sides that are equal but for round-off must not be told apart by it: the first wins.
TriangleSide longest_side(const TriangleMesh& mesh, Index count) {
  TriangleSide longest;
  double largest = 0.0;
  for (Index i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) {
      const double squared =
          (mesh.vertices.col(mesh.triangles(k, i)) - mesh.vertices.col(mesh.triangles((k + 1) % 3, i)))
              .squaredNorm();
      if (!(squared > largest * (1.0 + 1e-9))) continue;
      largest = squared;
      longest = {i, k};
    }
  }
  return longest;
}

/// The same side as its other triangle runs through it. @throws ArgumentError if there is none
TriangleSide other_side(const TriangleMesh& mesh, Index count, int from, int to) {
  for (Index i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k)
      if (mesh.triangles(k, i) == to && mesh.triangles((k + 1) % 3, i) == from) return {i, k};
  }
  refuse(
      fmt::format("it is not closed: the edge from corner {} to {} belongs to one triangle only", from, to));
}

}  // namespace

double enclosed_volume(const TriangleMesh& mesh) {
  if (mesh.triangles.cols() == 0) return 0.0;
  const Vector3d origin = origin_of(mesh);
  double volume = 0.0;
  for (Index i = 0; i < mesh.triangles.cols(); ++i) volume += signed_volume(mesh, i, origin);
  return volume;
}

TriangleMesh oriented_outward(TriangleMesh mesh) {
  if (enclosed_volume(mesh) < 0.0) mesh.triangles.row(1).swap(mesh.triangles.row(2));
  return mesh;
}

TriangleMesh divided(TriangleMesh mesh, int triangles) {
  Index count = mesh.triangles.cols(), corners = mesh.vertices.cols();
  if (count == 0 || count >= triangles) return mesh;
  // Each step makes two triangles and one corner.
  const Index steps = (triangles - count + 1) / 2;
  mesh.triangles.conservativeResize(3, count + 2 * steps);
  mesh.vertices.conservativeResize(3, corners + steps);
  for (Index step = 0; step < steps; ++step) {
    const TriangleSide one = longest_side(mesh, count);
    const int from = mesh.triangles(one.k, one.triangle), to = mesh.triangles((one.k + 1) % 3, one.triangle);
    const TriangleSide other = other_side(mesh, count, from, to);
    mesh.vertices.col(corners) = 0.5 * (mesh.vertices.col(from) + mesh.vertices.col(to));
    for (const TriangleSide& side : {one, other}) {
      Eigen::Vector3i second = mesh.triangles.col(side.triangle);
      second(side.k) = static_cast<int>(corners);
      mesh.triangles((side.k + 1) % 3, side.triangle) = static_cast<int>(corners);
      mesh.triangles.col(count++) = second;
    }
    ++corners;
  }
  return mesh;
}

void require_closed(const TriangleMesh& mesh) {
  require_numbers(mesh);
  require_used_corners(mesh);
  require_areas(mesh);
  const std::vector<Side> sides = sorted_sides(mesh);
  require_paired_sides(mesh, sides);
  const double size = size_of(mesh);
  const double no_volume = 1e-14 * size * size * size;
  require_oriented_parts(mesh, parts_of(mesh, sides), no_volume);
  const double volume = enclosed_volume(mesh);
  if (std::abs(volume) < no_volume) {
    refuse(fmt::format("its volume is {:.3g} m^3 at a size of {:.3g} m: it encloses nothing", volume, size));
  }
  if (volume < 0.0) {
    refuse(fmt::format(
        "its volume is {:.6g} m^3: the surface is inside out; oriented_outward() turns it over", volume));
  }
}

}  // namespace samara::models
