#include "samara/models/bodies/body.h"

#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/models/bodies/mesh_shapes.h"

using namespace samara::models;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

Matrix3d rotation(double angle, const Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

}  // namespace

TEST_CASE("ellipsoid, disc, plate and section have their textbook masses and moments") {
  const Body ellipsoid = ellipsoid_body({3, 2, 1}, 10.0);
  CHECK_THAT(ellipsoid.mass, WithinRel(80.0 * pi, 1e-15));
  CHECK((ellipsoid.principal.moments - 16.0 * pi * Vector3d(5, 10, 13)).norm() < 1e-12);
  CHECK(ellipsoid.principal.axes == Matrix3d::Identity());
  CHECK(ellipsoid.proxy_semi_axes == Vector3d(3, 2, 1));

  const Body disc = disc_body(2.0, 0.3, 5.0);
  CHECK_THAT(disc.volume, WithinRel(1.2 * pi, 1e-15));
  CHECK_THAT(disc.principal.moments[2], WithinRel(0.5 * disc.mass * 4.0, 1e-15));
  CHECK_THAT(disc.principal.moments[0], WithinRel(disc.mass * (1.0 + 0.09 / 12.0), 1e-15));
  CHECK((disc.proxy_semi_axes - Vector3d(2, 2, 0.15)).norm() < 1e-15);

  const Body plate = plate_body({0.3, 0.2, 0.01}, 1000.0);
  CHECK_THAT(plate.mass, WithinRel(0.6, 1e-15));
  CHECK_THAT(plate.principal.moments[2], WithinRel(0.6 * 0.13 / 12.0, 1e-14));
}

TEST_CASE("body axes put the longest extent first and the normal of a plate last") {
  const Body plate = plate_body({0.01, 0.2, 0.3}, 1000.0);
  CHECK((plate.proxy_semi_axes - Vector3d(0.15, 0.1, 0.005)).norm() < 1e-15);
  CHECK(plate.principal.axes.col(0) == Vector3d::UnitZ());
  CHECK(plate.principal.axes.col(1) == Vector3d::UnitY());
  CHECK_THAT(plate.principal.axes.determinant(), WithinRel(1.0, 1e-15));
}

TEST_CASE("a box as a mesh has the mass, centre and inertia of the plate, turned and far away") {
  const Vector3d sides(0.3, 0.2, 0.05), far(1e5, -2e5, 3e5);
  const Matrix3d R = rotation(0.8, {1, -2, 0.5});
  TriangleMesh mesh = box_mesh(sides, 3, 2);
  mesh.vertices = (R * mesh.vertices).colwise() + far;
  const Body by_mesh = mesh_body(mesh, 700.0), by_formula = plate_body(sides, 700.0);
  // Coordinates carry an absolute error of 3e5 eps = 7e-11, on a thickness of 0.05: 1.3e-9.
  CHECK_THAT(by_mesh.mass, WithinRel(by_formula.mass, 1e-8));
  CHECK((by_mesh.centre_of_mass - far).norm() < 1e-9);
  CHECK((by_mesh.principal.moments - by_formula.principal.moments).norm() <
        1e-8 * by_formula.principal.moments.norm());
  CHECK((by_mesh.proxy_semi_axes - by_formula.proxy_semi_axes).norm() < 1e-9);
  for (int k = 0; k < 3; ++k) {
    CHECK_THAT(std::abs(by_mesh.principal.axes.col(k).dot(R.col(k))), WithinAbs(1.0, 1e-9));
  }
}

TEST_CASE("the integrals over a polyhedron are exact: a tetrahedron off the origin") {
  TriangleMesh mesh;
  mesh.vertices.resize(3, 4);
  mesh.vertices << 1, 3, 1, 1,  //
      2, 2, 5, 2,               //
      3, 3, 3, 7;
  mesh.triangles.resize(3, 4);
  mesh.triangles << 0, 0, 0, 1,  //
      2, 1, 3, 2,                //
      1, 3, 2, 3;
  const Body body = mesh_body(mesh, 1.0);
  // Edges 2, 3, 4 along the axes: V = 24/6; about the centroid Int x^2 dV = V l^2 3/80, Int x y dV = -V l_x
  // l_y/80.
  CHECK_THAT(body.volume, WithinRel(4.0, 1e-14));
  CHECK((body.centre_of_mass - Vector3d(1.5, 2.75, 4.0)).norm() < 1e-14);
  const Vector3d l(2, 3, 4);
  Matrix3d second = -4.0 / 80.0 * (l * l.transpose());
  second.diagonal() = 4.0 * 3.0 / 80.0 * l.cwiseAbs2();
  const Matrix3d inertia = second.trace() * Matrix3d::Identity() - second;
  const Matrix3d& axes = body.principal.axes;
  CHECK((axes * body.principal.moments.asDiagonal() * axes.transpose() - inertia).norm() < 1e-13);
}

TEST_CASE("a mesh of an ellipsoid converges to the ellipsoid with the square of the triangle size") {
  const Vector3d s(3, 2, 0.5);
  const Body exact = ellipsoid_body(s, 1.0);
  double coarse[2], fine[2];
  for (int pass = 0; pass < 2; ++pass) {
    const Body body = mesh_body(ellipsoid_mesh(s, pass == 0 ? 10 : 20), 1.0);
    (pass == 0 ? coarse : fine)[0] = std::abs(body.mass / exact.mass - 1.0);
    (pass == 0 ? coarse : fine)[1] = std::abs(body.principal.moments[1] / exact.principal.moments[1] - 1.0);
  }
  for (int i = 0; i < 2; ++i) CHECK(std::log2(coarse[i] / fine[i]) > 1.95);
}

TEST_CASE("principal axes are a proper rotation that depends on nothing but the matrix") {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (int i = 0; i < 100; ++i) {
    const Matrix3d R = rotation(3.0 * number(random), {number(random), number(random), number(random)});
    const Vector3d moments(1.0, 2.0 + number(random), 5.0);
    const Matrix3d inertia = R * moments.asDiagonal() * R.transpose();
    const PrincipalAxes p = principal_axes(inertia);
    CHECK_THAT(p.axes.determinant(), WithinRel(1.0, 1e-14));
    CHECK((p.axes.transpose() * p.axes - Matrix3d::Identity()).norm() < 1e-14);
    CHECK((p.axes * p.moments.asDiagonal() * p.axes.transpose() - inertia).norm() < 1e-13);
    for (int k = 0; k < 2; ++k) {
      Eigen::Index largest;
      p.axes.col(k).cwiseAbs().maxCoeff(&largest);
      CHECK(p.axes(largest, k) > 0.0);
    }
    // Round-off in the matrix turns the axes by round-off, not over.
    const PrincipalAxes again = principal_axes(inertia + 1e-15 * Matrix3d::Ones());
    CHECK((again.axes - p.axes).norm() < 1e-12);
  }
}

TEST_CASE("among equal moments the axes next to the frame are taken") {
  CHECK(principal_axes(2.0 * Matrix3d::Identity()).axes.isApprox(Matrix3d::Identity(), 1e-14));
  CHECK(principal_axes(Vector3d(1, 1, 3).asDiagonal()).axes.isApprox(Matrix3d::Identity(), 1e-14));
  // A disc tilted about x, with round-off: x stays an axis.
  const Matrix3d R = rotation(0.5, Vector3d::UnitX());
  Matrix3d inertia = R * Vector3d(1, 1 + 1e-14, 3).asDiagonal() * R.transpose();
  inertia = 0.5 * (inertia + inertia.transpose()).eval();
  CHECK(principal_axes(inertia).axes.isApprox(R, 1e-12));
  CHECK_THROWS_AS(principal_axes(Matrix3d::Constant(std::nan(""))), samara::ArgumentError);
}

TEST_CASE("bodies without size or density are refused by name") {
  CHECK_THROWS_WITH(plate_body({0.1, 0.1, 0.0}, 700.0),
                    Contains("plate_body") && Contains("side along z [m] is 0"));
  CHECK_THROWS_WITH(disc_body(-1.0, 0.1, 700.0), Contains("radius [m] is -1"));
  CHECK_THROWS_WITH(ellipsoid_body({1, 1, 1}, 0.0), Contains("density of the solid [kg/m^3] is 0"));
  CHECK_THROWS_WITH(mesh_body(ellipsoid_mesh({1, 1, 1}, 2), std::nan("")), Contains("nan"));
}

TEST_CASE("what looks like a mistake of units is said") {
  const Vector3d card(0.035, 0.02, 1e-4);
  CHECK(unit_warnings(ellipsoid_body(card, 1200.0), 1.2).empty());
  CHECK(unit_warnings(ellipsoid_body(card, 2700.0), 998.0).empty());

  const auto density = unit_warnings(ellipsoid_body(card, 1.2), 1.2);
  REQUIRE(density.size() == 1);
  CHECK_THAT(density[0], Contains("looks like g/cm^3; 1200 kg/m^3?"));
  CHECK(unit_warnings(ellipsoid_body(card, 1200.0), 1.2e-3).size() == 1);
  CHECK(unit_warnings(ellipsoid_body(card, 1200.0), 100.0).size() == 1);
  const auto size = unit_warnings(ellipsoid_body(1000.0 * card, 1200.0), 1.2);
  REQUIRE(size.size() == 1);
  CHECK_THAT(size[0], Contains("70 m long"));
  CHECK_THAT(unit_warnings(ellipsoid_body(1e-3 * card, 1200.0), 1.2).at(0),
             Contains("scaled to metres twice"));
}
