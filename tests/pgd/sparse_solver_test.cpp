#include "samara/pgd/linear/sparse_solver.h"

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/pgd/axes/axis.h"
#include "samara/pgd/tensors/random.h"

using namespace samara::pgd;

namespace {

const std::vector<SparseSolverKind> kAllSolvers = {SparseSolverKind::automatic, SparseSolverKind::eigen_ldlt,
                                                   SparseSolverKind::eigen_lu, SparseSolverKind::cholmod,
                                                   SparseSolverKind::umfpack};

SparseMatrix two_by_two(double a, double b, double c, double d) {
  SparseMatrix matrix(2, 2);
  matrix.insert(0, 0) = a;
  matrix.insert(0, 1) = b;
  matrix.insert(1, 0) = c;
  matrix.insert(1, 1) = d;
  matrix.makeCompressed();
  return matrix;
}

double error_of(SparseSolverKind kind, const SparseMatrix& matrix) {
  Random random(3);
  const Eigen::MatrixXd exact = Eigen::MatrixXd::NullaryExpr(
      matrix.cols(), 3, [&](Eigen::Index, Eigen::Index) { return random.normal(); });
  const auto solver = make_sparse_solver(kind, matrix);
  Eigen::MatrixXd x(exact.rows(), exact.cols());
  const bool solved = solver->factorize(matrix) && solver->solve(matrix * exact, x);
  return solved ? (x - exact).norm() / exact.norm() : 1.0;
}

}  // namespace

TEST_CASE("every sparse solver solves symmetric positive systems") {
  const Axis x = Axis::p1({"x"}, 0.0, 1.0, 300);
  for (const SparseSolverKind kind : kAllSolvers) {
    CAPTURE(to_string(kind));
    if (is_available(kind)) CHECK(error_of(kind, x.mass() + x.stiffness()) < 1e-9);
  }
}

TEST_CASE("solvers by LU take systems that are not symmetric") {
  const Axis t = Axis::radau({"t"}, 0.0, 1.0, 20, 4);
  const SparseMatrix matrix = t.derivative() + 3.0 * t.mass();
  for (const SparseSolverKind kind :
       {SparseSolverKind::automatic, SparseSolverKind::eigen_lu, SparseSolverKind::umfpack}) {
    CAPTURE(to_string(kind));
    if (is_available(kind)) CHECK(error_of(kind, matrix) < 1e-9);
  }
}

TEST_CASE("solvers for symmetric systems refuse others") {
  for (const SparseSolverKind kind : {SparseSolverKind::eigen_ldlt, SparseSolverKind::cholmod}) {
    if (!is_available(kind)) continue;
    const SparseMatrix matrix = two_by_two(2.0, 1.0, 0.0, 3.0);
    CHECK_FALSE(make_sparse_solver(kind, matrix)->factorize(matrix));
  }
}

TEST_CASE("the automatic choice survives pivots that break the factorisation without pivoting") {
  CHECK(error_of(SparseSolverKind::automatic, two_by_two(0.0, 1.0, 1.0, 0.0)) < 1e-14);
  CHECK(error_of(SparseSolverKind::automatic, two_by_two(1e-18, 1.0, 1.0, 1.0)) < 1e-14);
}

TEST_CASE("singular matrices are reported") {
  const SparseMatrix singular = two_by_two(1.0, 1.0, 1.0, 1.0);
  const Eigen::MatrixXd b = Eigen::Vector2d(1.0, 2.0);
  for (const SparseSolverKind kind : kAllSolvers) {
    if (!is_available(kind)) continue;
    CAPTURE(to_string(kind));
    const auto solver = make_sparse_solver(kind, singular);
    Eigen::MatrixXd x(2, 1);
    CHECK_FALSE((solver->factorize(singular) && solver->solve(b, x)));
  }
}

TEST_CASE("one analysis serves matrices of one pattern") {
  const Axis x = Axis::p1({"x"}, 0.0, 1.0, 50);
  for (const SparseSolverKind kind : kAllSolvers) {
    if (!is_available(kind)) continue;
    CAPTURE(to_string(kind));
    const auto solver = make_sparse_solver(kind, x.mass());
    for (const double shift : {1.0, 10.0, 1000.0}) {
      const SparseMatrix matrix = shift * x.mass() + x.stiffness();
      const Eigen::MatrixXd exact = x.nodes();
      Eigen::MatrixXd found(x.size(), 1);
      REQUIRE(solver->factorize(matrix));
      REQUIRE(solver->solve(matrix * exact, found));
      CHECK((found - exact).norm() < 1e-10 * exact.norm());
    }
  }
}
