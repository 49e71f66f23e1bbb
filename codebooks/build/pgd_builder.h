#pragma once

#include "samara/base/progress.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/build/solution.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/models/interface/parametric_model.h"

namespace samara::codebooks {

/// Solves a plan by the PGD engine, without integrating any trajectory.
/// @param options its checkpoint and warning
/// @param max_evaluations of the right-hand side and its Jacobian; 0: no limit
/// @throws InputError for a checkpoint that is broken or of another plan.
Solution solve_by_pgd(const Plan& plan, const models::ParametricModel& model, const BuildOptions& options,
                      long max_evaluations, const ProgressCallback& progress);

}  // namespace samara::codebooks
