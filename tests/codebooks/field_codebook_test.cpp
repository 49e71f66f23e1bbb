// Fields of linear problems of one's own as codebooks.
#include "samara/codebooks/fields/field_codebook.h"

#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "../../examples/linear_engine/disc.h"
#include "../../examples/linear_engine/heat.h"
#include "../io/temporary_directory.h"
#include "samara/base/errors.h"
#include "samara/codebooks/certify/builder_end.h"
#include "samara/codebooks/fields/direct_reference.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/place_query.h"
#include "samara/codebooks/query/query.h"
#include "same_codebook.h"

using namespace samara::codebooks;
using namespace samara::pgd;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;

namespace {

EnrichResult solved(const ParametricProblem& problem, Projection projection, double residual) {
  EnrichOptions options;
  options.projection = projection;
  options.residual_tolerance = residual;
  options.update_sweeps = 4;
  return enrich(problem.assemble(), options);
}

FieldRequest request_of(const std::string& name, int points, double tolerance) {
  FieldRequest request{.output = {"u", "K"}};
  request.problem.name = name;
  request.certify.points = points;
  request.certify.tolerance = tolerance;
  return request;
}

const Heat& wall() {
  static const Heat heat(16);
  return heat;
}

const Codebook& wall_book() {
  static const Codebook book =
      make_codebook(wall().problem(), solved(wall().problem(), Projection::minimal_residual, 3e-4),
                    request_of("wall", 40, 2e-3));
  return book;
}

const HeatedDisc& disc() {
  static const HeatedDisc disc(100);
  return disc;
}

SpaceMesh mesh_of(const Mesh& mesh, int nodes) {
  Eigen::MatrixXd points(2, nodes);
  for (int i = 0; i < nodes; ++i) points.col(i) = mesh.place(i);
  Eigen::MatrixXi cells(3, static_cast<Eigen::Index>(mesh.triangles.size()));
  for (std::size_t c = 0; c < mesh.triangles.size(); ++c) {
    for (std::size_t i = 0; i < 3; ++i)
      cells(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) = mesh.triangles[c][i];
  }
  return SpaceMesh({"x", "y"}, "m", points, cells);
}

const Codebook& disc_book() {
  static const Codebook book = [] {
    FieldRequest request = request_of("heated_disc", 12, 1e-6);
    request.mesh = mesh_of(disc().mesh, disc().place.size());
    return make_codebook(disc().problem(), solved(disc().problem(), Projection::galerkin, 1e-7), request);
  }();
  return book;
}

}  // namespace

TEST_CASE("a field of place, time and three parameters is certified, saved and asked like any codebook") {
  CAPTURE(wall_book().certificate()->max_error, wall_book().build().message);
  CHECK(wall_book().certificate()->met);
  CHECK_THAT(wall_book().certificate()->integrator, Contains("CVODE"));
  const TemporaryDirectory directory;
  save(wall_book(), directory / "wall.h5");
  const Codebook book = load(directory / "wall.h5");
  check_same_codebook(book, wall_book());
  // Time comes first, although it is the problem's second axis; the border's value is a coordinate as it was.
  CHECK(book.coordinates()[0].name == "t");
  CHECK(book.coordinates()[1].name == "x");
  CHECK(book.coordinates()[3].role == AxisRole::boundary);
  Query query(book);
  Eigen::VectorXd value(1);
  query.values(std::vector{0.0, 0.25, 0.5, 1.5, -0.5}, value);
  // u(0,x) = g (1 - x)^2 + a sin(pi x), at a node of space.
  CHECK_THAT(value[0], WithinAbs(1.5 * 0.75 * 0.75 - 0.5 * std::sin(0.25 * std::numbers::pi), 1e-9));
  query.values(std::vector{0.7, 0.0, 0.2, 1.5, -0.5}, value);
  CHECK_THAT(value[0], WithinAbs(1.5, 1e-9));
}

TEST_CASE("the direct solution in time is the exact one of a problem that has one") {
  // du/dt = k u'' with u = a sin(pi x) exp(-k pi^2 t), spectral in space.
  const Axis x = Axis::legendre({"x", "m", AxisRole::space}, 0.0, 1.0, 18);
  const Axis t = Axis::radau({"t", "s", AxisRole::time}, 0.0, 0.5, 6, 5);
  const Axis k = Axis::chebyshev({"k"}, 0.5, 1.0, 4);
  const Axis a = Axis::chebyshev({"a"}, 1.0, 2.0, 2);
  ParametricProblem problem({x, t, k, a});
  problem.add_term({{"t", ModeOperator::sparse(t.derivative())}}, 2.0);
  problem.add_term({{"x", ModeOperator::sparse(x.stiffness())}, {"k", ModeOperator::diagonal(k.nodes())}},
                   2.0);
  problem.know("x", {0, x.size() - 1});
  problem.know("t", {0});
  const Eigen::VectorXd sine = nodal_values(x, [](double s) { return std::sin(std::numbers::pi * s); });
  problem.add_to_lift({{"x", sine}, {"a", a.nodes()}});
  const FieldReference reference = direct_reference(problem, 1.0);
  const std::vector<double> q = {0.77, 1.3}, times = {0.0, 0.1, 0.45};
  const Eigen::VectorXd places = Eigen::VectorXd::LinSpaced(9, 0.0, 1.0);
  const Eigen::MatrixXd u = reference.values(q, times, places);
  REQUIRE(u.rows() == 3);
  REQUIRE(u.cols() == 9);
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j < 9; ++j) {
      constexpr double pi = std::numbers::pi;
      const double exact =
          1.3 * std::sin(pi * places[j]) * std::exp(-0.77 * pi * pi * times[static_cast<std::size_t>(i)]);
      CHECK_THAT(u(i, j), WithinAbs(exact, 1e-7));
    }
  }
}

TEST_CASE(
    "the direct solution follows a border value that ramps up, from the beginning on, wherever times begin") {
  // Two elements of time, u(t,0) = 2 t until 0.5 and then 1. As a reference, ramps of finite elements in time: the
  // answer to a step is 1 - x - sum 2/(n pi) sin(n pi x) exp(-n^2 pi^2 t), that to a ramp of slope 2 its integral.
  constexpr double pi = std::numbers::pi;
  const Axis x = Axis::legendre({"x", "m", AxisRole::space}, 0.0, 1.0, 24);
  const Axis t = Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 2, 5);
  ParametricProblem problem({x, t});
  problem.add_term({{"t", ModeOperator::sparse(t.derivative())}});
  // The identity in time may come as a sparse matrix, too.
  SparseMatrix identity(t.size(), t.size());
  identity.setIdentity();
  problem.add_term({{"x", ModeOperator::sparse(x.stiffness())}, {"t", ModeOperator::sparse(identity)}});
  problem.know("x", {0, x.size() - 1});
  problem.know("t", {0});
  const Eigen::VectorXd ramp = t.nodes().unaryExpr([](double s) { return std::min(2.0 * s, 1.0); });
  problem.add_to_lift({{"t", ramp}, {"x", 1.0 - x.nodes().array()}});
  const auto after_ramp = [](double time, double place) {  // of slope 2, gone on
    if (time <= 0.0) return 0.0;
    double value = 2.0 * (1.0 - place) * time;
    for (int n = 1; n < 2000; ++n) {
      value -= 4.0 / std::pow(n * pi, 3) * std::sin(n * pi * place) * -std::expm1(-n * n * pi * pi * time);
    }
    return value;
  };
  const FieldReference reference = direct_reference(problem, 1.0);
  const Eigen::VectorXd places = Eigen::VectorXd::LinSpaced(9, 0.0, 1.0);
  for (const std::vector<double>& times :
       {std::vector{0.0, 0.2, 0.5, 0.52, 0.6, 0.7, 0.9}, std::vector{0.3, 0.61}}) {
    const Eigen::MatrixXd u = reference.values({}, times, places);
    for (Eigen::Index i = 0; i < u.rows(); ++i) {
      const double time = times[static_cast<std::size_t>(i)];
      for (Eigen::Index j = 0; j < u.cols(); ++j) {
        CAPTURE(time, places[j]);
        CHECK_THAT(u(i, j), WithinAbs(after_ramp(time, places[j]) - after_ramp(time - 0.5, places[j]), 1e-6));
      }
    }
  }
  CHECK_THROWS_WITH(reference.values({}, {-0.1, 0.5}, places), Contains("expected one from 0 on"));
}

TEST_CASE("a field on an imported mesh of 10201 nodes is certified, saved and asked at nodes and between") {
  CAPTURE(disc_book().certificate()->max_error, disc_book().build().message);
  CHECK(disc_book().certificate()->met);
  CHECK(disc_book().certificate()->places == 10201);
  CHECK(verdict(disc_book().build(), *disc_book().certificate()) == "met at 12 points");
  CHECK_THAT(disc_book().certificate()->integrator, Contains("direct solution"));
  CHECK_FALSE(disc_book().has_time());
  const TemporaryDirectory directory;
  save(disc_book(), directory / "disc.h5");
  const Codebook book = load(directory / "disc.h5");
  check_same_codebook(book, disc_book());
  Query at_nodes(book);
  PlaceQuery in_space(book);
  REQUIRE(in_space.coordinates().size() == 4);
  CHECK(in_space.coordinates()[1].name == "y");
  Eigen::VectorXd corner(1), value(1);
  Eigen::MatrixXd gradient(1, 4);
  const int node = disc().mesh.node(37, 61);
  at_nodes.values(std::vector{static_cast<double>(node), 0.7, 2.0}, corner);
  CHECK(corner[0] > 1e-3);
  in_space.values(std::vector{0.37, 0.61, 0.7, 2.0}, value, gradient);
  CHECK_THAT(value[0], WithinAbs(corner[0], 1e-12));
  // In the triangle of the nodes (40, 52), (41, 52), (40, 53) the field is linear.
  const auto nodal = [&](int i, int j) {
    at_nodes.values(std::vector{static_cast<double>(disc().mesh.node(i, j)), 0.7, 2.0}, corner);
    return corner[0];
  };
  in_space.values(std::vector{0.402, 0.523, 0.7, 2.0}, value, gradient);
  const double a = nodal(40, 52), b = nodal(41, 52), c = nodal(40, 53);
  CHECK_THAT(value[0], WithinAbs(0.5 * a + 0.2 * b + 0.3 * c, 1e-14));
  CHECK_THAT(gradient(0, 0), WithinAbs(100.0 * (b - a), 1e-10));
  CHECK_THAT(gradient(0, 1), WithinAbs(100.0 * (c - a), 1e-10));
  CHECK_THAT(gradient(0, 3), WithinAbs(value[0] / 2.0, 1e-8));  // linear in the strength of the source
  CHECK_THROWS_AS(in_space.values(std::vector{1.2, 0.5, 0.7, 2.0}, value), samara::OutsideBoxError);
  CHECK_THROWS_AS(at_nodes.values(std::vector{3.5, 0.7, 2.0}, value), samara::OutsideBoxError);
}

TEST_CASE("a solution that stopped early is a codebook that is not met") {
  EnrichOptions options;
  options.projection = Projection::minimal_residual;
  options.residual_tolerance = 1e-6;
  options.max_rank = 2;
  const EnrichResult result = enrich(wall().problem().assemble(), options);
  const Codebook book = make_codebook(wall().problem(), result, request_of("wall", 5, 1.0));
  CHECK(book.build().status == samara::Termination::rank_limit);
  CHECK_FALSE(book.certificate()->met);
}

TEST_CASE("problems that make no codebook are refused in words") {
  const ParametricProblem problem = wall().problem();
  EnrichResult result;
  result.solution = problem.assemble().rhs;
  const auto refused = [&](const FieldRequest& request) { return make_codebook(problem, result, request); };
  CHECK_THROWS_WITH(refused(request_of("heat_rod", 5, 1.0)),
                    Contains("\"heat_rod\", expected one that no model has"));
  CHECK_THROWS_WITH(refused(request_of("", 5, 1.0)), Contains("not empty"));
  FieldRequest with_mesh = request_of("wall", 5, 1.0);
  with_mesh.mesh = mesh_of(disc().mesh, disc().place.size());
  CHECK_THROWS_WITH(refused(with_mesh), Contains("interpolates between"));
  // Coefficients that change in time are beyond the direct solution.
  ParametricProblem moving({wall().x, wall().t});
  moving.add_term({{"t", ModeOperator::sparse(wall().t.derivative())}});
  moving.add_term(
      {{"t", ModeOperator::diagonal(wall().t.nodes())}, {"x", ModeOperator::sparse(wall().x.stiffness())}});
  CHECK_THROWS_WITH(direct_reference(moving, 1.0), Contains("other nodes are known than the first"));
  moving.know("t", {0});
  CHECK_THROWS_WITH(direct_reference(moving, 1.0), Contains("neither its derivative nor constant"));
  // So are those that only look constant where a parameter is zero.
  const Axis share = Axis::chebyshev({"share"}, 0.0, 1.0, 2);
  ParametricProblem growing({wall().x, wall().t, share});
  growing.add_term({{"t", ModeOperator::sparse(wall().t.derivative())}});
  growing.add_term({{"t", ModeOperator::diagonal(wall().t.nodes())},
                    {"x", ModeOperator::sparse(wall().x.stiffness())},
                    {"share", ModeOperator::diagonal(share.nodes())}});
  growing.know("t", {0});
  CHECK_THROWS_WITH(direct_reference(growing, 1.0), Contains("neither its derivative nor constant"));
  ParametricProblem nowhere({share});
  nowhere.add_term({});
  EnrichResult nothing;
  nothing.solution = nowhere.assemble().rhs;
  CHECK_THROWS_WITH(make_codebook(nowhere, nothing, request_of("nowhere", 5, 1.0)),
                    Contains("no axis of space"));
  const Axis y = Axis::p1({"y", "m", AxisRole::space}, 0.0, 1.0, 4);
  ParametricProblem plane({wall().x, y});
  plane.add_term({{"x", ModeOperator::sparse(wall().x.stiffness())}});
  CHECK_THROWS_WITH(direct_reference(plane, 1.0), Contains("2 axes of space"));
}
