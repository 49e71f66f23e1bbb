#pragma once

#include <string>
#include <vector>

#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/pgd/evolution/slab_evolution.h"

/// What a build has cost, against the plainest way to the same accuracy: a sweep of the reference integrator over
/// a grid of the parameters. The sweep is told for nothing how many nodes it needs; a build has to find out, and
/// to check.
namespace samara::codebooks {

/// Trajectories of a sweep over the grid of these pieces: per cell, all nodes of the parameter axes, each axis
/// with the most nodes that it has in any piece of the cell.
/// @param pieces time comes first among their axes
double sweep_size(const std::vector<Piece>& pieces);

/// Evaluations of f that the reference integrator takes for a trajectory at a tenth of the plan's tolerance: the
/// mean over a few points of the box; 0 where none of them can be integrated.
double evaluations_per_trajectory(const Plan& plan, const models::ParametricModel& model);

/// Where a few short slabs took half of the evaluations of a march: ", and 61 % of .." with their times, and the
/// kink of the law that lies there, if one is found. Empty: the work is spread over time.
std::string costly_slabs(const pgd::SlabResult& result, const models::ParametricModel& model);

}  // namespace samara::codebooks
