// The linear engine on problems whose answers are known from elsewhere.
#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>
#include <unsupported/Eigen/MatrixFunctions>

#include "examples/linear_engine/disc.h"
#include "examples/linear_engine/heat.h"
#include "examples/linear_engine/moving_load.h"
#include "examples/linear_engine/poisson.h"
#include "samara/pgd/linear/enrichment.h"
#include "samara/pgd/linear/residual.h"
#include "samara/pgd/tensors/thin_svd.h"

using namespace samara::pgd;

namespace {

EnrichOptions fixed_rank(Projection projection, int rank) {
  EnrichOptions options;
  options.projection = projection;
  options.residual_tolerance = 1e-15;
  options.max_rank = rank;
  options.stagnation_terms = rank;
  options.update_sweeps = 4;
  return options;
}

/// Relative error against the exact discrete solution in two dimensions, by the sine transform.
double poisson_error(const SeparatedTensor& u) {
  const Eigen::Index n = u.factors[0].rows();
  Eigen::MatrixXd vectors(n, n);
  Eigen::VectorXd values(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double angle = std::numbers::pi * static_cast<double>(k + 1) / static_cast<double>(n + 1);
    values[k] = 2.0 * (1.0 - std::cos(angle)) * static_cast<double>((n + 1) * (n + 1));
    for (Eigen::Index i = 0; i < n; ++i)
      vectors(i, k) =
          std::sqrt(2.0 / static_cast<double>(n + 1)) * std::sin(angle * static_cast<double>(i + 1));
  }
  const Eigen::VectorXd load = vectors.transpose() * Eigen::VectorXd::Ones(n);
  Eigen::MatrixXd exact = load * load.transpose();
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) exact(i, j) /= values[i] + values[j];
  }
  const Eigen::MatrixXd found =
      vectors.transpose() * u.factors[0] * u.weights.asDiagonal() * u.factors[1].transpose() * vectors;
  return (found - exact).norm() / exact.norm();
}

}  // namespace

TEST_CASE("Poisson's equation in two dimensions is near the best sum of as many terms") {
  // The singular value decomposition gives 1.4e-6 and 3.9e-11.
  CHECK(poisson_error(enrich(poisson(2, 63), fixed_rank(Projection::galerkin, 5)).solution) < 3e-6);
  CHECK(poisson_error(enrich(poisson(2, 63), fixed_rank(Projection::galerkin, 10)).solution) < 2e-10);
}

TEST_CASE("Poisson's equation in up to fifty dimensions takes few terms, whatever the seed") {
  for (const auto& [dimensions, most] : {std::pair{10, 20}, std::pair{20, 30}, std::pair{50, 30}}) {
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      EnrichOptions options = fixed_rank(Projection::galerkin, most);
      options.residual_tolerance = 1e-3;
      options.seed = seed;
      const LinearProblem problem = poisson(dimensions, 63);
      const EnrichResult result = enrich(problem, options);
      CAPTURE(dimensions, seed, result.message);
      CHECK(result.termination == samara::Termination::converged);
      CHECK(relative_residual(problem, result.solution) < 1.001e-3);
    }
  }
}

TEST_CASE("under a moving load the minimal residual never increases, and beats Galerkin's error") {
  const MovingLoad load;
  const LinearProblem problem = load.problem().assemble();
  const Eigen::MatrixXd exact = load.march();
  const Eigen::VectorXd singular = thin_svd(exact).singular;
  double error[2] = {0.0, 0.0};
  for (const Projection projection : {Projection::galerkin, Projection::minimal_residual}) {
    const EnrichResult result = enrich(problem, fixed_rank(projection, 10));
    const SeparatedTensor& u = result.solution;
    const Eigen::MatrixXd values = u.factors[0] * u.weights.asDiagonal() * u.factors[1].transpose();
    error[static_cast<int>(projection)] = (values - exact).norm() / exact.norm();
    if (projection == Projection::galerkin) continue;
    for (std::size_t r = 1; r < result.history.size(); ++r)
      CHECK(result.history[r].residual <= result.history[r - 1].residual * (1.0 + 1e-9));
  }
  const double best = singular.tail(singular.size() - 10).norm() / singular.norm();
  CHECK(error[1] < error[0]);
  CHECK(error[1] < 1.1 * best);
}

TEST_CASE("heat over conductivity, boundary value and initial amplitude agrees with matrix exponentials") {
  const Heat heat(16);
  const ParametricProblem problem = heat.problem();
  EnrichOptions options;
  options.residual_tolerance = 3e-5;
  options.update_sweeps = 4;
  const EnrichResult result = enrich(problem.assemble(), options);
  REQUIRE(result.termination == samara::Termination::converged);
  const SeparatedTensor u = problem.complete(result.solution);
  const int n = heat.x.size() - 2;
  const Eigen::MatrixXd mass = Eigen::MatrixXd(heat.x.mass()).block(1, 1, n, n);
  const Eigen::MatrixXd stiffness = heat.x.stiffness();
  const Eigen::VectorXd x = heat.x.nodes().segment(1, n);
  double largest = 0.0;
  for (const int ik : {0, 9, 19}) {
    for (const int corner : {0, 1, 2, 3}) {
      const int ig = corner % 2;
      const int ia = corner / 2;
      const double k = heat.k.nodes()[ik];
      const double g = heat.g.nodes()[ig];
      const Eigen::MatrixXd matrix = -k * mass.llt().solve(stiffness.block(1, 1, n, n));
      const Eigen::VectorXd steady =
          matrix.lu().solve(k * g * mass.llt().solve(stiffness.col(0).segment(1, n)));
      const Eigen::VectorXd start =
          g * (1.0 - x.array()).square() + heat.a.nodes()[ia] * (std::numbers::pi * x.array()).sin();
      for (const int it : {5, 20, 35, 50}) {
        const Eigen::VectorXd exact = steady + (matrix * heat.t.nodes()[it]).exp() * (start - steady);
        for (int i = 0; i < n; ++i) {
          const std::vector<int> index = {i + 1, it, ik, ig, ia};
          largest = std::max(largest, std::abs(u.entry(index) - exact[i]));
        }
      }
    }
  }
  CHECK(largest < 1e-4 * 4.0);  // the range of u
}

TEST_CASE("a mesh from elsewhere is one axis") {
  const HeatedDisc disc(20);
  const ParametricProblem problem = disc.problem();
  EnrichOptions options;
  options.projection = Projection::galerkin;
  options.residual_tolerance = 1e-8;
  const EnrichResult result = enrich(problem.assemble(), options);
  REQUIRE(result.termination == samara::Termination::converged);
  const SeparatedTensor u = problem.complete(result.solution);
  const int n = disc.place.size();
  for (const int ik : {0, 7, 15}) {
    Eigen::MatrixXd matrix = disc.mesh.stiffness_plate + disc.k.nodes()[ik] * disc.mesh.stiffness_disc;
    Eigen::VectorXd load = disc.mesh.mass * disc.source();
    for (const int node : disc.mesh.border) {
      matrix.row(node).setZero();
      matrix(node, node) = 1.0;
      load[node] = 0.0;
    }
    const Eigen::VectorXd exact = matrix.partialPivLu().solve(load);
    for (int i = 0; i < n; i += 7) {
      const std::vector<int> index = {i, ik, 0};
      CHECK(u.entry(index) == Approx(exact[i]).margin(1e-6 * exact.maxCoeff()));
    }
  }
}
