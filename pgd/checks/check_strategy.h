#pragma once

#include "samara/base/check.h"
#include "samara/pgd/evolution/adaptive_problem.h"
#include "samara/pgd/nonlinear/strategy.h"

/// The test for a strategy of your own, on a problem that suits it.
///
///   const samara::Check check = samara::pgd::check_strategy(mine, problem);
///   for (const std::string& finding : check.findings) std::cerr << finding << "\n";
///
/// The strategy solves the first slabs of the problem by itself (nonlinear/strategy_trial.h). Looked at is
///  - whether it gets there, and says why where it does not: by an Ending, nothing thrown;
///  - whether a second march gives the same numbers: nothing that a slab leaves behind may change the next one,
///    because marches that are taken up again begin without it;
///  - of one that is exact, whether it leaves a defect in the equations below the tolerance, and a smaller one
///    where less is asked for; and what it makes of rates that are not finite, and of ranks that are too small:
///    it must not claim to have converged.
namespace samara::pgd {

struct CheckStrategyOptions {
  double tolerance = 1e-4;  ///< of a slab, in scales
  int slabs = 2;            ///< from t = 0 on
  /// Of all time, the length of a slab; short enough for the strategy to contract.
  double slab = 0.05;
  int nodes = 9;  ///< of axes whose nodes the problem leaves open
  std::uint64_t seed = 1;
};

/// @throws ArgumentError if the problem or an option is outside its meaning, or the problem does not suit the
/// strategy (Strategy::prepare()).
Check check_strategy(Strategy& strategy, const AdaptiveProblem& problem,
                     const CheckStrategyOptions& options = {});

}  // namespace samara::pgd
