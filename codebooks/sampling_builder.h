#pragma once

#include "samara/base/progress.h"
#include "samara/codebooks/plan.h"
#include "samara/codebooks/solution.h"
#include "samara/models/parametric_model.h"

namespace samara::codebooks {

/// Trajectories that a build by sampling may ask for where the plan sets no limit.
inline constexpr long kMostTrajectories = 100'000;

/// Solves a plan by sampling trajectories of the reference integrator (pgd/sampling.h).
///
/// Pilots, in corners and inside of the box, choose the time axis: interpolation between its nodes follows
/// them to 0.1 of the tolerance. Then every call integrates one trajectory and gives all outputs at all nodes
/// of time; the cross is built to half the tolerance. The first core of the train, over outputs and times, is
/// split into one of the outputs and one of time.
///
/// A trajectory that cannot be integrated ends the build with the status "failed" and the point; the best so
/// far, or else the initial values for all times, is the piece.
/// @param max_trajectories pilots included
Solution solve_by_sampling(const Plan& plan, const models::ParametricModel& model, long max_trajectories,
                           const ProgressCallback& progress);

}  // namespace samara::codebooks
