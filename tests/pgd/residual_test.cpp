#include "samara/pgd/linear/residual.h"

#include <limits>

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "random_tensor.h"
#include "samara/base/errors.h"
#include "samara/pgd/linear/enrichment.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

namespace {

Eigen::MatrixXd random_matrix(int n, Random& random) {
  return Eigen::MatrixXd::NullaryExpr(n, n, [&](Eigen::Index, Eigen::Index) { return random.normal(); });
}

/// A small problem of two modes with a dense and a sparse part on each, and its matrix (first mode fastest).
struct Small {
  LinearProblem problem;
  Eigen::MatrixXd matrix;  ///< 20 x 20
  Eigen::VectorXd rhs;

  explicit Small(std::uint64_t seed) {
    Random random(seed);
    matrix = Eigen::MatrixXd::Zero(20, 20);
    for (int i = 0; i < 3; ++i) {
      const Eigen::MatrixXd a = random_matrix(4, random) + 4.0 * Eigen::MatrixXd::Identity(4, 4);
      const Eigen::MatrixXd b = random_matrix(5, random) + 4.0 * Eigen::MatrixXd::Identity(5, 5);
      problem.op.terms.push_back({ModeOperator::dense(a), ModeOperator::sparse(b.sparseView())});
      for (int p = 0; p < 5; ++p) {
        for (int q = 0; q < 5; ++q) matrix.block(4 * p, 4 * q, 4, 4) += b(p, q) * a;
      }
    }
    problem.rhs = random_tensor({4, 5}, 3, seed + 1);
    rhs = vector_of(problem.rhs);
  }

  static Eigen::VectorXd vector_of(const SeparatedTensor& u) {
    const Eigen::MatrixXd values = u.factors[0] * u.weights.asDiagonal() * u.factors[1].transpose();
    return Eigen::Map<const Eigen::VectorXd>(values.data(), values.size());
  }
};

Eigen::MatrixXd kron_rows(const Eigen::MatrixXd& first, const Eigen::MatrixXd& second) {
  Eigen::MatrixXd product(first.rows() * second.rows(), first.cols() * second.cols());
  for (Eigen::Index p = 0; p < second.rows(); ++p) {
    for (Eigen::Index q = 0; q < second.cols(); ++q)
      product.block(first.rows() * p, first.cols() * q, first.rows(), first.cols()) = second(p, q) * first;
  }
  return product;
}

}  // namespace

TEST_CASE("cheap and exact residual agree with the dense one, in every measure") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Small small(seed);
    Random random(seed + 50);
    const Eigen::MatrixXd root = random_matrix(4, random);
    const Eigen::MatrixXd norm = root * root.transpose() + Eigen::MatrixXd::Identity(4, 4);
    const Eigen::VectorXd weights = Eigen::VectorXd::LinSpaced(5, 0.5, 2.0);
    const SeparatedTensor u = random_tensor({4, 5}, 4, seed + 9);
    const Eigen::VectorXd r = small.matrix * Small::vector_of(u) - small.rhs;
    CHECK(fast_relative_residual(small.problem, u) == Approx(r.norm() / small.rhs.norm()).epsilon(1e-9));
    CHECK(relative_residual(small.problem, u) == Approx(r.norm() / small.rhs.norm()).epsilon(1e-9));

    small.problem.row_weights = {{}, weights};
    small.problem.row_norms = {SparseMatrix(norm.sparseView())};
    const Eigen::MatrixXd metric = kron_rows(norm.inverse(), Eigen::MatrixXd(weights.asDiagonal()));
    const double expected = std::sqrt(r.dot(metric * r) / small.rhs.dot(metric * small.rhs));
    CHECK(fast_relative_residual(small.problem, u) == Approx(expected).epsilon(1e-9));
    CHECK(relative_residual(small.problem, u) == Approx(expected).epsilon(1e-9));
  }
}

TEST_CASE("the exact residual resolves what inner products cannot") {
  const Small small(7);
  EnrichOptions options;
  options.residual_tolerance = 1e-13;
  options.residual = ResidualKind::exact;
  const EnrichResult result = enrich(small.problem, options);
  const Eigen::VectorXd r = small.matrix * Small::vector_of(result.solution) - small.rhs;
  CHECK(result.residual < 1e-12);
  CHECK(r.norm() / small.rhs.norm() < 1e-12);
}

TEST_CASE("both projections solve small problems of mixed parts in any measure") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    for (const bool measured : {false, true}) {
      Small small(seed);
      if (measured) {
        small.problem.row_weights = {{}, Eigen::VectorXd::LinSpaced(5, 0.5, 2.0)};
        small.problem.row_norms = {SparseMatrix((4.0 * Eigen::MatrixXd::Identity(4, 4)).sparseView())};
      }
      const EnrichResult result = enrich(small.problem, {.residual_tolerance = 1e-10, .update_sweeps = 10});
      REQUIRE(result.termination == samara::Termination::converged);
      const Eigen::VectorXd exact = small.matrix.partialPivLu().solve(small.rhs);
      CHECK((Small::vector_of(result.solution) - exact).norm() < 1e-7 * exact.norm());
    }
  }
}

TEST_CASE("a norm that is no norm is refused") {
  Small small(1);
  SparseMatrix negative(4, 4);
  negative.setIdentity();
  negative.coeffRef(2, 2) = -1.0;
  small.problem.row_norms = {negative};
  CHECK_THROWS_WITH(enrich(small.problem), Contains("norm of mode 0") && Contains("positive"));
  SparseMatrix lopsided(4, 4);
  lopsided.setIdentity();
  lopsided.coeffRef(0, 3) = 0.5;
  small.problem.row_norms = {lopsided};
  CHECK_THROWS_WITH(enrich(small.problem), Contains("norm of mode 0") && Contains("symmetric"));
  lopsided.coeffRef(0, 3) = 0.0;
  lopsided.coeffRef(0, 0) = std::numeric_limits<double>::infinity();
  small.problem.row_norms = {lopsided};
  CHECK_THROWS_WITH(enrich(small.problem), Contains("norm of mode 0"));
  small.problem.row_norms = {SparseMatrix(3, 3)};
  CHECK_THROWS_WITH(enrich(small.problem), Contains("3 x 3, expected 4 x 4"));
}
