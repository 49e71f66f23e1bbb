// Axes that are lists of nodes: discrete values and imported mass matrices.

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/pgd/axes/axis.h"
#include "samara/pgd/fields/separated_field.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

namespace {

SparseMatrix sparse(const Eigen::MatrixXd& dense) {
  return dense.sparseView();
}

/// A consistent mass matrix: that of a P1 axis.
SparseMatrix sample_mass() {
  return Axis::p1({"x"}, Eigen::Vector4d(0.0, 0.5, 0.6, 2.0)).mass();
}

std::string refusal(const Eigen::MatrixXd& mass) {
  try {
    Axis::imported({"mesh"}, sparse(mass));
  } catch (const samara::ArgumentError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("a discrete axis counts its values and knows nothing between them") {
  const Axis axis = Axis::discrete({"plies"}, Eigen::Vector4d(1.0, 2.0, 4.0, 8.0));
  CHECK(axis.size() == 4);
  CHECK(axis.lower() == 1.0);
  CHECK(axis.upper() == 8.0);
  CHECK(axis.measure() == 4.0);
  CHECK(Eigen::MatrixXd(axis.mass()) == Eigen::MatrixXd::Identity(4, 4));
  CHECK(axis.weights() == Eigen::VectorXd::Ones(4));
  CHECK_FALSE(axis.has_elements());
  for (const double x : {1.0, 2.0, 4.0, 8.0}) CHECK(axis.contains(x));
  for (const double x : {0.0, 1.5, 7.999, 9.0, std::nan("")}) CHECK_FALSE(axis.contains(x));
}

TEST_CASE("a discrete axis answers with the nearest value, the lower one of two") {
  const Axis axis = Axis::discrete({"plies"}, Eigen::Vector4d(1.0, 2.0, 4.0, 8.0));
  InterpolationStencil stencil = axis.make_stencil();
  REQUIRE(axis.stencil_size() == 1);
  const auto nearest = [&](double x) {
    axis.interpolate(x, stencil, true);
    CHECK(stencil.value[0] == 1.0);
    CHECK(std::isnan(stencil.derivative[0]));
    return stencil.first;
  };
  CHECK(nearest(1.0) == 0);
  CHECK(nearest(8.0) == 3);
  CHECK(nearest(1.5) == 0);
  CHECK(nearest(1.6) == 1);
  CHECK(nearest(5.9) == 2);
  CHECK(nearest(6.1) == 3);
  CHECK(nearest(-5.0) == 0);
  CHECK(nearest(50.0) == 3);
}

TEST_CASE("a list of a single value is an axis") {
  const Axis axis = Axis::discrete({"plies"}, Eigen::VectorXd::Constant(1, 3.0));
  InterpolationStencil stencil = axis.make_stencil();
  axis.interpolate(7.0, stencil, false);
  CHECK(stencil.first == 0);
  CHECK(axis.contains(3.0));
  CHECK(axis.measure() == 1.0);
}

TEST_CASE("an imported axis has the mass it was given and its row sums as weights") {
  const SparseMatrix mass = sample_mass();
  const Axis axis = Axis::imported({"mesh", "1", AxisRole::space}, mass);
  CHECK(Eigen::MatrixXd(axis.mass()) == Eigen::MatrixXd(mass));
  CHECK(axis.nodes() == Eigen::VectorXd::LinSpaced(4, 0.0, 3.0));
  CHECK((axis.weights() - Axis::p1({"x"}, Eigen::Vector4d(0.0, 0.5, 0.6, 2.0)).weights()).norm() < 1e-15);
  CHECK(axis.measure() == Approx(2.0).epsilon(1e-15));
  CHECK(axis.contains(2.0));
  CHECK_FALSE(axis.contains(1.5));
  CHECK_FALSE(axis.contains(4.0));
}

TEST_CASE("lists have no gradient, stiffness or derivative, and say so") {
  const Axis discrete = Axis::discrete({"plies"}, Eigen::Vector2d(1.0, 2.0));
  const Axis imported = Axis::imported({"mesh"}, sample_mass());
  CHECK_THROWS_WITH(discrete.gradient(), Contains("axis \"plies\" is discrete") && Contains("no gradient"));
  CHECK_THROWS_WITH(discrete.stiffness(), Contains("no stiffness"));
  CHECK_THROWS_WITH(discrete.derivative(), Contains("no derivative"));
  CHECK_THROWS_WITH(imported.gradient(), Contains("axis \"mesh\" is imported"));
  CHECK_THROWS_AS(imported.stiffness(), samara::ArgumentError);
  CHECK_THROWS_AS(imported.derivative(), samara::ArgumentError);
  CHECK_THROWS_AS(imported.degree(), samara::ArgumentError);
}

TEST_CASE("a field over lists has factors of mean square one, answers at the values and refuses others") {
  const Axis plies = Axis::discrete({"plies"}, Eigen::Vector2d(1.0, 2.0));
  const Axis mesh = Axis::imported({"mesh"}, sample_mass());
  const Axis x = Axis::legendre({"x"}, 0.0, 1.0, 4);
  const Eigen::VectorXd mesh_values = Eigen::Vector4d(1.0, -2.0, 3.0, 0.5);
  const SeparatedField field({plies, mesh, x}, {{"u"}}, {Eigen::Vector2d(3.0, 5.0), mesh_values, x.nodes()},
                             Eigen::MatrixXd::Ones(1, 1));
  CHECK(field.factors()[0].squaredNorm() == Approx(2.0));
  CHECK(field.factors()[1].col(0).dot(mesh.mass() * field.factors()[1].col(0)) == Approx(2.0));
  SeparatedField::Workspace workspace = field.make_workspace();
  Eigen::VectorXd value(1);
  Eigen::MatrixXd gradient(1, 3);
  field.evaluate(std::vector{2.0, 1.0, 0.25}, value, gradient, workspace);
  CHECK(value[0] == Approx(5.0 * -2.0 * 0.25));
  CHECK(gradient(0, 2) == Approx(5.0 * -2.0));
  CHECK(std::isnan(gradient(0, 0)));
  CHECK_THROWS_AS(field(std::vector{1.5, 1.0, 0.25}), samara::OutsideBoxError);
  CHECK_THROWS_WITH(field(std::vector{1.5, 1.0, 0.25}),
                    Contains("plies = 1.5 is none of the 2 values of its axis"));
}

TEST_CASE("values that make no list are refused by name") {
  const double nan = std::nan("");
  CHECK_THROWS_WITH(Axis::discrete({"plies"}, Eigen::VectorXd()),
                    Contains("axis \"plies\": the number of nodes is 0"));
  CHECK_THROWS_WITH(Axis::discrete({"plies"}, Eigen::Vector2d(2.0, 2.0)), Contains("increasing"));
  CHECK_THROWS_WITH(Axis::discrete({"plies"}, Eigen::Vector2d(1.0, nan)), Contains("not finite"));
  CHECK_THROWS_WITH(
      Axis::discrete({"plies", "1", AxisRole::parameter, Transform::reciprocal}, Eigen::Vector2d(1.0, 2.0)),
      Contains("\"reciprocal\", which a discrete axis cannot have"));
}

TEST_CASE("a matrix that is no mass matrix is refused with the entry that shows it") {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  CHECK_THAT(refusal(Eigen::MatrixXd::Identity(2, 3)), Contains("axis \"mesh\" is 2 x 3, expected square"));
  CHECK_THAT(refusal(Eigen::MatrixXd(0, 0)), Contains("0 x 0"));
  Eigen::Matrix3d mass = Eigen::Matrix3d::Identity();
  mass(1, 2) = 0.1;
  CHECK_THAT(refusal(mass), Contains("not symmetric") && Contains("(1, 2)"));
  mass(2, 1) = 0.1;
  CHECK(refusal(mass) == "no error");
  mass(2, 1) = 0.1 + 1e-15;  // rounding in an assembly
  CHECK(refusal(mass) == "no error");
  mass(1, 2) = mass(2, 1) = -1.0;
  CHECK_THAT(refusal(mass), Contains("not positive definite"));
  mass(0, 2) = kInfinity;
  CHECK_THAT(refusal(mass), Contains("holds inf at (0, 2)"));
  CHECK_THAT(refusal(Eigen::Vector2d(1.0, 0.0).asDiagonal()), Contains("holds 0 on its diagonal, at 1"));
  CHECK_THAT(refusal(Eigen::Vector2d(-1.0, 1.0).asDiagonal()), Contains("holds -1 on its diagonal, at 0"));
  CHECK_THROWS_WITH(Axis::imported({"mesh", "1", AxisRole::space, Transform::logarithm},
                                   sparse(Eigen::Matrix2d::Identity())),
                    Contains("imported axis cannot have"));
}
