#pragma once

#include <string>

#include "samara/base/progress.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/build/solution.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/pgd/evolution/adaptive_problem.h"

namespace samara::codebooks {

/// Whether a plan's strategy is one of those that march over slabs of time by linear problems
/// (pgd/nonlinear/strategy.h): incremental, polynomial, asymptotic, empirical, piecewise_linear, cross.
bool is_marched(const std::string& strategy);

/// Solves a plan by the strategy it names. Slabs are halved as long as the strategy does not contract on
/// them; axes whose nodes the plan leaves open get more where random points off the grid leave a defect in
/// the equations. A strategy that solves other equations by nature (polynomial, piecewise_linear) ends with
/// the status "missed" where no refinement helps, and with its field.
/// @param max_evaluations of f and its Jacobian; 0: no limit
/// @throws ArgumentError if the plan's kind is "pgd" and it is to resume from a checkpoint: it keeps none.
/// NoResultError if the strategy fails on the first slab, however short.
Solution solve_by_strategy(const Plan& plan, const pgd::AdaptiveProblem& problem, const BuildOptions& options,
                           long max_evaluations, const ProgressCallback& progress);

}  // namespace samara::codebooks
