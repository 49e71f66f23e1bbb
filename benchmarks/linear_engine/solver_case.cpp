// Sparse solvers on matrices as the engine meets them: plane and solid meshes, and the block systems of factor
// updates, from analysis to solution.
#include <algorithm>
#include <vector>

#include <unsupported/Eigen/KroneckerProduct>

#include "cases.h"
#include "samara/pgd/axes/axis.h"
#include "samara/pgd/linear/sparse_solver.h"
#include "samara/pgd/tensors/random.h"

namespace samara::benchmarks {

namespace {

using pgd::SparseMatrix;
using pgd::SparseSolverKind;

SparseMatrix kronecker(const SparseMatrix& a, const SparseMatrix& b) {
  return Eigen::kroneckerProduct(a, b);
}

struct Line {
  SparseMatrix mass, stiffness;
  explicit Line(int nodes) {
    const pgd::Axis x = pgd::Axis::p1({"x"}, 0.0, 1.0, nodes);
    mass = x.mass();
    stiffness = x.stiffness();
  }
};

/// Bilinear elements on a square of side^2 nodes: mass and stiffness.
Line plane(int side) {
  const Line x(side);
  Line result(2);
  result.mass = kronecker(x.mass, x.mass);
  result.stiffness = kronecker(x.stiffness, x.mass) + kronecker(x.mass, x.stiffness);
  return result;
}

/// Trilinear ones on a cube.
Line solid(int side) {
  const Line x(side), xy = plane(side);
  Line result(2);
  result.mass = kronecker(xy.mass, x.mass);
  result.stiffness = kronecker(xy.stiffness, x.mass) + kronecker(xy.mass, x.stiffness);
  return result;
}

SparseMatrix shifted(const Line& form) {
  return form.stiffness + form.mass;
}

/// What an update of `terms` factors over an axis solves at once: dense couplings of two parts.
SparseMatrix blocks(const Line& form, int terms) {
  pgd::Random random(5);
  const Eigen::MatrixXd factor =
      Eigen::MatrixXd::NullaryExpr(terms, terms, [&](Eigen::Index, Eigen::Index) { return random.normal(); });
  const Eigen::MatrixXd coupling = factor * factor.transpose() + Eigen::MatrixXd::Identity(terms, terms);
  const Eigen::MatrixXd other =
      Eigen::MatrixXd::Constant(terms, terms, 0.3) + Eigen::MatrixXd::Identity(terms, terms);
  return kronecker(form.stiffness, coupling.sparseView()) + kronecker(form.mass, other.sparseView());
}

/// With a wind along the first direction.
SparseMatrix unsymmetric(int side) {
  const pgd::Axis x = pgd::Axis::p1({"x"}, 0.0, 1.0, side);
  return shifted(plane(side)) + 3.0 * kronecker(x.mass(), x.gradient());
}

void measure(const Options& options, const std::string& name, const SparseMatrix& matrix, bool symmetric) {
  const Eigen::MatrixXd b = Eigen::MatrixXd::Ones(matrix.rows(), 1);
  Eigen::MatrixXd x(matrix.rows(), 1);
  double automatic = 0.0, best = 1e300;
  for (const SparseSolverKind kind :
       {SparseSolverKind::automatic, SparseSolverKind::eigen_ldlt, SparseSolverKind::eigen_lu,
        SparseSolverKind::cholmod, SparseSolverKind::umfpack}) {
    const bool takes_symmetric_only =
        kind == SparseSolverKind::eigen_ldlt || kind == SparseSolverKind::cholmod;
    if (!is_available(kind) || (takes_symmetric_only && !symmetric)) continue;
    // Of the largest ones, Eigen's LU takes minutes where others take seconds, and so does LDL^T of a solid.
    const bool is_largest = matrix.nonZeros() > 2'000'000, is_solid = matrix.nonZeros() > 20 * matrix.rows();
    if (is_largest &&
        (kind == SparseSolverKind::eigen_lu || (kind == SparseSolverKind::eigen_ldlt && is_solid)))
      continue;
    bool solved = false;
    const double seconds = time_of(
        [&] {
          const auto solver = make_sparse_solver(kind, matrix);
          solved = solver->factorize(matrix) && solver->solve(b, x);
        },
        options.quick ? 1 : 2, 0.0);
    if (!solved) continue;
    print({kLinearEngine, "solver_sizes", name + "_" + to_string(kind), seconds, "s"});
    if (kind == SparseSolverKind::automatic) {
      automatic = seconds;
    } else {
      best = std::min(best, seconds);
    }
  }
  print({kLinearEngine, "solver_sizes", name + "_automatic_over_best", automatic / best, "1"});
}

}  // namespace

void run_solver_sizes(const Options& options) {
  if (!options.wants("solver_sizes")) return;
  measure(options, "line_100000", shifted(Line(100'000)), true);
  measure(options, "plane_10000", shifted(plane(100)), true);
  measure(options, "plane_100000", shifted(plane(316)), true);
  measure(options, "solid_10000", shifted(solid(22)), true);
  measure(options, "blocks_line_10000x4", blocks(Line(10'000), 4), true);
  measure(options, "blocks_plane_2500x8", blocks(plane(50), 8), true);
  measure(options, "wind_10000", unsymmetric(100), false);
  measure(options, "wind_100000", unsymmetric(316), false);
  if (options.quick) return;
  measure(options, "plane_1000000", shifted(plane(1000)), true);
  measure(options, "solid_100000", shifted(solid(46)), true);
}

}  // namespace samara::benchmarks
