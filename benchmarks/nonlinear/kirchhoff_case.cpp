// (6.24) as six equations, an ellipsoid of semi-axes 4, 2, 1 cm in water, over its six initial velocities.
#include <algorithm>

#include "cases.h"
#include "problems.h"
#include "samara/pgd/evolution/slab_evolution.h"

namespace samara::benchmarks {

void run_kirchhoff7(const Options& options) {
  using namespace pgd;
  constexpr const char* kName = "kirchhoff7";
  if (!options.wants(kName)) return;
  const Problem problem = kirchhoff(0.4);
  const EvolutionProblem grid = problem.on(1, 2, 2);
  AdaptiveProblem adaptive;
  adaptive.system = problem.system.get();
  adaptive.time = {"t", "s", AxisRole::time};
  adaptive.end = problem.end;
  for (const Interval& interval : problem.box)
    adaptive.parameters.push_back({{interval.name, "1", AxisRole::initial}, interval.lower, interval.upper});
  adaptive.states = grid.states;
  adaptive.scales = grid.scales;
  adaptive.scale_floors.assign(6, 0.0);
  adaptive.initial = grid.initial;
  const SlabResult result = solve_by_slabs(adaptive, {.tolerance = 1e-3});
  const auto value = [&](std::span<const double> x) -> Eigen::VectorXd {
    for (const TrainField& field : result.pieces) {
      if (field.axes()[0].contains(x[0])) return field(x);
    }
    return Eigen::VectorXd::Constant(6, std::nan(""));
  };
  const Errors errors = errors_of(problem, value, problem.end, 1000);
  int rank = 0;
  for (const SlabRecord& record : result.history) {
    for (const int r : record.ranks) rank = std::max(rank, r);
  }
  print({kNonlinear, kName, "error_rms", errors.relative_rms.maxCoeff()});
  print({kNonlinear, kName, "error_max", errors.largest.maxCoeff()});
  print({kNonlinear, kName, "rank", static_cast<double>(rank)});
  print({kNonlinear, kName, "time", result.seconds, "s"});
  print({kNonlinear, kName, "evaluation_fraction",
         static_cast<double>(result.evaluations) / result.grid_evaluations});
  print({kNonlinear, kName, "met", result.status == samara::Termination::converged ? 1.0 : 0.0});
}

}  // namespace samara::benchmarks
