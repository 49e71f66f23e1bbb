// Transient diffusion under a moving point load (Allier, Chamoin and Ladeveze 2015): the projections against
// the best sum of as many terms.
#include <Eigen/LU>
#include <Eigen/SVD>
#include <fmt/format.h>

#include "cases.h"
#include "examples/linear_engine/moving_load.h"
#include "samara/pgd/linear/enrichment.h"

namespace samara::benchmarks {

namespace {
using namespace pgd;

Eigen::MatrixXd as_matrix(const SeparatedTensor& u) {
  return u.factors[0] * u.weights.asDiagonal() * u.factors[1].transpose();
}
}  // namespace

void run_moving_load(const Options& options) {
  constexpr const char* kName = "moving_load";
  constexpr int kTerms = 20;
  if (!options.wants(kName)) return;
  const MovingLoad load;
  const LinearProblem problem = load.problem().assemble();
  const Eigen::MatrixXd exact = load.march();
  const Eigen::VectorXd singular = Eigen::BDCSVD<Eigen::MatrixXd>(exact).singularValues();
  for (const Projection projection : {Projection::galerkin, Projection::minimal_residual}) {
    const char* method = projection == Projection::galerkin ? "galerkin" : "minres";
    EnrichOptions with;
    with.projection = projection;
    with.residual_tolerance = 1e-15;
    with.max_rank = kTerms;
    with.stagnation_terms = kTerms;
    with.update_sweeps = 4;
    with.checkpoint = [&](const EnrichState& state) {
      const double error = (as_matrix(state.solution) - exact).norm() / exact.norm();
      print({kLinearEngine, kName, fmt::format("{}_{}", method, state.solution.rank()), error, "1"});
      print({kLinearEngine, kName, fmt::format("{}_residual_{}", method, state.solution.rank()),
             state.residual, "1"});
    };
    enrich(problem, with);
  }
  for (int rank = 1; rank <= kTerms; ++rank) {
    print({kLinearEngine, kName, fmt::format("svd_{}", rank),
           singular.tail(singular.size() - rank).norm() / singular.norm(), "1"});
  }
}

}  // namespace samara::benchmarks
