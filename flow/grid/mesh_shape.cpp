#include "samara/flow/grid/mesh_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "samara/base/require.h"

namespace samara::flow {

namespace {

/// A point on a triangle, and on which of its parts: 0 to 2 corners, 3 to 5 the edges from them on, 6 the face.
struct NearestPoint {
  Eigen::Vector3d point;
  int part = 6;
};

/// C. Ericson, Real-Time Collision Detection (2005), 5.1.5: by the regions about corners, edges and face.
NearestPoint nearest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                 const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {a, 0};
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return {b, 1};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return {a + d1 / (d1 - d3) * ab, 3};
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return {c, 2};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return {a + d2 / (d2 - d6) * ac, 5};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return {b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), 4};
  const double sum = va + vb + vc;
  return {a + vb / sum * ab + vc / sum * ac, 6};
}

/// Triangles in a binary tree of boxes, with the normals of all their parts.
class MeshDistance {
 public:
  explicit MeshDistance(models::TriangleMesh mesh) : mesh_(std::move(mesh)) {
    set_normals();
    order_.resize(static_cast<std::size_t>(mesh_.triangles.cols()));
    std::iota(order_.begin(), order_.end(), 0);
    build(0, static_cast<int>(order_.size()));
  }

  double operator()(const Eigen::Vector3d& p) const {
    Best best;
    search(0, p, best);
    const Eigen::Vector3d& normal =
        normals_[static_cast<std::size_t>(best.triangle)][static_cast<std::size_t>(best.nearest.part)];
    const double distance = std::sqrt(best.squared);
    return (p - best.nearest.point).dot(normal) < 0.0 ? -distance : distance;
  }

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    int begin = 0, end = 0;
    int children[2] = {-1, -1};  ///< -1: a leaf
  };
  struct Best {
    double squared = std::numeric_limits<double>::infinity();
    int triangle = 0;
    NearestPoint nearest;
  };

  Eigen::Vector3d corner(int triangle, int which) const {
    return mesh_.vertices.col(mesh_.triangles(which, triangle));
  }

  void set_normals() {
    const auto count = static_cast<int>(mesh_.triangles.cols());
    Eigen::Matrix3Xd at_corner = Eigen::Matrix3Xd::Zero(3, mesh_.vertices.cols());
    std::map<std::pair<int, int>, Eigen::Vector3d> at_edge;
    const auto edge_of = [&](int t, int e) {
      return std::minmax({mesh_.triangles(e, t), mesh_.triangles((e + 1) % 3, t)});
    };
    normals_.resize(static_cast<std::size_t>(count));
    for (int t = 0; t < count; ++t) {
      const Eigen::Vector3d normal =
          (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).normalized();
      normals_[static_cast<std::size_t>(t)][6] = normal;
      for (int e = 0; e < 3; ++e) {
        const Eigen::Vector3d on = corner(t, (e + 1) % 3) - corner(t, e),
                              back = corner(t, (e + 2) % 3) - corner(t, e);
        at_corner.col(mesh_.triangles(e, t)) += std::atan2(on.cross(back).norm(), on.dot(back)) * normal;
        at_edge.try_emplace(edge_of(t, e), Eigen::Vector3d::Zero()).first->second += normal;
      }
    }
    for (int t = 0; t < count; ++t) {
      for (int e = 0; e < 3; ++e) {
        normals_[static_cast<std::size_t>(t)][static_cast<std::size_t>(e)] =
            at_corner.col(mesh_.triangles(e, t));
        normals_[static_cast<std::size_t>(t)][static_cast<std::size_t>(e + 3)] = at_edge.at(edge_of(t, e));
      }
    }
  }

  /// @returns the number of the node
  int build(int begin, int end) {
    const auto number = static_cast<int>(nodes_.size());
    nodes_.emplace_back();
    Node node;
    node.begin = begin;
    node.end = end;
    for (int i = begin; i < end; ++i) {
      for (int v = 0; v < 3; ++v) node.box.extend(corner(order_[static_cast<std::size_t>(i)], v));
    }
    constexpr int kLeaf = 4;
    if (end - begin > kLeaf) {
      Eigen::Index axis = 0;
      node.box.sizes().maxCoeff(&axis);
      const int middle = (begin + end) / 2;
      const auto centre = [&](int t) { return corner(t, 0)(axis) + corner(t, 1)(axis) + corner(t, 2)(axis); };
      std::nth_element(
          order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
          [&](int s, int t) { return centre(s) < centre(t) || (centre(s) == centre(t) && s < t); });
      node.children[0] = build(begin, middle);
      node.children[1] = build(middle, end);
    }
    nodes_[static_cast<std::size_t>(number)] = node;
    return number;
  }

  void search(int number, const Eigen::Vector3d& p, Best& best) const {
    const Node& node = nodes_[static_cast<std::size_t>(number)];
    if (node.children[0] < 0) {
      for (int i = node.begin; i < node.end; ++i) {
        const int t = order_[static_cast<std::size_t>(i)];
        const NearestPoint nearest = nearest_on_triangle(p, corner(t, 0), corner(t, 1), corner(t, 2));
        const double squared = (p - nearest.point).squaredNorm();
        if (squared < best.squared) best = {squared, t, nearest};
      }
      return;
    }
    const auto squared_to = [&](int child) {
      return nodes_[static_cast<std::size_t>(node.children[child])].box.squaredExteriorDistance(p);
    };
    const int nearer = squared_to(0) <= squared_to(1) ? 0 : 1;
    for (const int child : {nearer, 1 - nearer}) {
      if (squared_to(child) < best.squared) search(node.children[child], p, best);
    }
  }

  models::TriangleMesh mesh_;
  /// Outward, of the parts of NearestPoint; not of unit length.
  std::vector<std::array<Eigen::Vector3d, 7>> normals_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace

Shape mesh_shape(const models::TriangleMesh& mesh, double thickness) {
  models::require_closed(mesh);
  require(thickness > 0.0 && thickness <= 1.0, "thickness", thickness, "more than 0, at most 1",
          "mesh_shape");
  models::TriangleMesh scaled = mesh;
  const Eigen::Vector3d low = mesh.vertices.rowwise().minCoeff(), high = mesh.vertices.rowwise().maxCoeff();
  const double longest = (high - low).maxCoeff();
  scaled.vertices = (mesh.vertices.colwise() - 0.5 * (low + high)) / longest;
  Shape shape;
  shape.kind = "mesh";
  shape.dimensions = 3;
  shape.half = 0.5 * (high - low) / longest;
  shape.thickness = thickness;
  shape.volume = models::enclosed_volume(scaled);
  shape.corners = scaled.vertices;
  shape.sizes.assign(scaled.vertices.data(), scaled.vertices.data() + scaled.vertices.size());
  shape.sizes.insert(shape.sizes.end(), scaled.triangles.data(),
                     scaled.triangles.data() + scaled.triangles.size());
  shape.distance = [distance = std::make_shared<const MeshDistance>(std::move(scaled))](
                       const Eigen::Vector3d& x) { return (*distance)(x); };
  return shape;
}

}  // namespace samara::flow
