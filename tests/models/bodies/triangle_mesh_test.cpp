#include "samara/models/bodies/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/models/bodies/mesh_shapes.h"

using namespace samara::models;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices.resize(3, 4);
  mesh.vertices << 0, 1, 0, 0,  //
      0, 0, 1, 0,               //
      0, 0, 0, 1;
  mesh.triangles.resize(3, 4);
  mesh.triangles << 0, 0, 0, 1,  //
      2, 1, 3, 2,                //
      1, 3, 2, 3;
  return mesh;
}

/// Both surfaces in one mesh, nothing shared.
TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh;
  mesh.vertices.resize(3, a.vertices.cols() + b.vertices.cols());
  mesh.vertices << a.vertices, b.vertices;
  mesh.triangles.resize(3, a.triangles.cols() + b.triangles.cols());
  mesh.triangles << a.triangles, b.triangles.array() + static_cast<int>(a.vertices.cols());
  return mesh;
}

TriangleMesh inside_out(TriangleMesh mesh) {
  mesh.triangles.row(1).swap(mesh.triangles.row(2));
  return mesh;
}

TriangleMesh shifted(TriangleMesh mesh, double along_x) {
  mesh.vertices.row(0).array() += along_x;
  return mesh;
}

}  // namespace

TEST_CASE("a tetrahedron is closed and has its volume, wherever it stands") {
  TriangleMesh mesh = tetrahedron();
  CHECK_NOTHROW(require_closed(mesh));
  CHECK_THAT(enclosed_volume(mesh), WithinRel(1.0 / 6.0, 1e-15));
  mesh.vertices.colwise() += Eigen::Vector3d(1e6, -1e6, 1e6);  // exact in these coordinates
  CHECK_THAT(enclosed_volume(mesh), WithinRel(1.0 / 6.0, 1e-15));
}

TEST_CASE("an open mesh is refused by the name of an edge") {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.conservativeResize(3, 3);
  CHECK_THROWS_WITH(require_closed(mesh), Contains("not closed") &&
                                              Contains("corners 1 (1, 0, 0) and 2 (0, 1, 0)") &&
                                              Contains("one triangle only"));
}

TEST_CASE("an edge of more than two triangles is refused") {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.conservativeResize(3, 5);
  mesh.triangles.col(4) << 1, 2, 3;
  CHECK_THROWS_WITH(require_closed(mesh), Contains("belongs to 3 triangles"));
}

TEST_CASE("neighbours of opposite orientation are refused by the name of their edge") {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.col(3) << 2, 1, 3;
  CHECK_THROWS_WITH(require_closed(mesh),
                    Contains("oriented differently") && Contains("the edge between corners"));
}

TEST_CASE("a mesh inside out is refused, and turned over on demand") {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.row(1).swap(mesh.triangles.row(2));
  CHECK_THROWS_WITH(require_closed(mesh), Contains("inside out") && Contains("oriented_outward"));
  const TriangleMesh turned = oriented_outward(mesh);
  CHECK_NOTHROW(require_closed(turned));
  CHECK(oriented_outward(turned).triangles == turned.triangles);
}

TEST_CASE("meshes without volume, without area, without triangles or with odd numbers are refused") {
  TriangleMesh flat = tetrahedron();
  flat.vertices(2, 3) = 0.0;
  flat.vertices.col(3) << 0.3, 0.3, 0.0;
  CHECK_THROWS_WITH(require_closed(flat), Contains("encloses nothing"));

  TriangleMesh needle = tetrahedron();
  needle.vertices.col(3) << 0.5, 0.0, 0.0;
  CHECK_THROWS_WITH(require_closed(needle), Contains("has no area"));

  CHECK_THROWS_WITH(require_closed(TriangleMesh{}), Contains("no triangles"));

  TriangleMesh beyond = tetrahedron();
  beyond.triangles(0, 0) = 4;
  CHECK_THROWS_WITH(require_closed(beyond), Contains("names corner 4 of 4"));

  TriangleMesh nan = tetrahedron();
  nan.vertices(1, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(require_closed(nan), Contains("corner 2") && Contains("not finite"));
  CHECK_THROWS_AS(require_closed(nan), samara::ArgumentError);
}

TEST_CASE("a corner of no triangle is refused by its number") {
  TriangleMesh mesh = tetrahedron();
  mesh.vertices.conservativeResize(3, 6);
  mesh.vertices.col(4) << 50.0, 0.0, 0.0;
  mesh.vertices.col(5) << 60.0, 0.0, 0.0;
  CHECK_THROWS_WITH(require_closed(mesh), Contains("corner 4 (50, 0, 0) belongs to no triangle"));
}

TEST_CASE("a separate part inside out is refused, unless it is the wall of a cavity") {
  const TriangleMesh large = box_mesh({2.0, 2.0, 2.0}, 1, 1), small = box_mesh({1.0, 1.0, 1.0}, 1, 1);
  CHECK_NOTHROW(require_closed(joined(large, shifted(small, 5.0))));
  CHECK_THROWS_WITH(require_closed(joined(large, shifted(inside_out(small), 5.0))),
                    Contains("of its 2 separate parts, that of triangle 12 at ") &&
                        Contains("is inside out (its volume is -1 m^3)"));
  // Equal and opposite volumes: the whole encloses none, which is not what is wrong.
  CHECK_THROWS_WITH(require_closed(joined(inside_out(small), shifted(small, 5.0))),
                    Contains("that of triangle 0 at "));
  const TriangleMesh hollow = joined(large, inside_out(small));
  CHECK_NOTHROW(require_closed(hollow));
  CHECK_THAT(enclosed_volume(hollow), WithinRel(7.0, 1e-14));
  CHECK_THROWS_WITH(require_closed(joined(inside_out(large), shifted(inside_out(small), 5.0))),
                    Contains("oriented_outward"));
}

TEST_CASE(
    "generated meshes are closed, of the number of triangles they promise, and of the volume asked for") {
  const Eigen::Vector3d s(3.0, 2.0, 0.5);
  const double volume = 4.0 * std::numbers::pi;
  const TriangleMesh rings = ellipsoid_mesh(s, 5, 7);
  CHECK_NOTHROW(require_closed(rings));
  CHECK(rings.triangles.cols() == 2 * 7 * 25);
  CHECK(enclosed_volume(rings) < volume);
  CHECK_THAT(enclosed_volume(ellipsoid_mesh(s, 5, 7, Placement::equal_volume)), WithinRel(volume, 1e-14));
  CHECK_NOTHROW(require_closed(ellipsoid_mesh(s, 1, 3)));

  const TriangleMesh even = icosahedral_ellipsoid_mesh(s, 4);
  CHECK_NOTHROW(require_closed(even));
  CHECK(even.triangles.cols() == 320);
  CHECK(even.vertices.cols() == 162);
  // Corners lie on the surface.
  CHECK(((even.vertices.array().colwise() / s.array()).square().colwise().sum() - 1.0).abs().maxCoeff() <
        1e-14);

  const TriangleMesh box = box_mesh({1.0, 2.0, 0.1}, 3, 4, 2);
  CHECK_NOTHROW(require_closed(box));
  CHECK(box.triangles.cols() == 4 * (3 * 4 + 2 * (3 + 4)));
  CHECK_THAT(enclosed_volume(box), WithinRel(0.2, 1e-14));

  CHECK_THROWS_WITH(box_mesh({1.0, 1.0, 0.0}, 1, 1), Contains("side along z [m] is 0"));
  CHECK_THROWS_WITH(ellipsoid_mesh(s, 0), Contains("number of rings is 0"));
  CHECK_THROWS_WITH(icosahedral_ellipsoid_mesh({1, -1, 1}, 2), Contains("semi-axis along y [m] is -1"));
}

TEST_CASE("a mesh is divided into as many triangles as are asked for, and stays the same surface") {
  // A box of twelve triangles, and a needle of a thousandth of its length.
  for (const Eigen::Vector3d& sides : {Eigen::Vector3d(4.0, 2.0, 1.0), Eigen::Vector3d(1.0, 1e-3, 1e-3)}) {
    const TriangleMesh box = box_mesh(sides, 1, 1);
    const TriangleMesh fine = divided(box, 500);
    CHECK(fine.triangles.cols() == 500);
    CHECK_NOTHROW(require_closed(fine));
    CHECK_THAT(enclosed_volume(fine), WithinRel(sides.prod(), 1e-13));
    // No side is left that is long for its number of triangles: those of the needle were as long as it is.
    double longest = 0.0;
    for (Eigen::Index i = 0; i < fine.triangles.cols(); ++i) {
      for (int k = 0; k < 3; ++k)
        longest = std::max(longest, (fine.vertices.col(fine.triangles(k, i)) -
                                     fine.vertices.col(fine.triangles((k + 1) % 3, i)))
                                        .norm());
    }
    CHECK(longest < 0.15 * sides[0]);
  }
  const TriangleMesh mesh = divided(tetrahedron(), 4);  // enough of them already
  CHECK(mesh.triangles == tetrahedron().triangles);
  CHECK(mesh.vertices == tetrahedron().vertices);
  CHECK(divided(tetrahedron(), 5).triangles.cols() == 6);  // two a step
  TriangleMesh open = tetrahedron();
  open.triangles.conservativeResize(3, 3);
  CHECK_THROWS_WITH(divided(open, 100), Contains("not closed"));
}
