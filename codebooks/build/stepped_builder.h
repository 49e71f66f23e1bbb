#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "samara/base/progress.h"
#include "samara/base/termination.h"
#include "samara/codebooks/build/sampling_builder.h"
#include "samara/codebooks/build/solution.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/models/interface/parametric_model.h"

namespace samara::codebooks {

/// Where a solver's state lies between two builds.
struct KeptState {
  std::vector<double> state = {};   ///< to go on from; empty: from the beginning
  std::filesystem::path file = {};  ///< to name where the state is refused
  std::function<void(const std::vector<double>&)> save = {};
};

/// Solves a plan by whole trajectories of Runge-Kutta steps, thousands side by side (models/batch/batch.h): each
/// costs microseconds, so that a build may take millions of them where sampling by the reference integrator takes
/// thousands. Nothing is marched: a trajectory is exact to its steps, whatever the field is before it.
///
///  1. The step is halved until pilots, in corners and inside of the box, no longer see it, and the mesh of time
///     follows them (time_mesh.h).
///  2. Along lines through the box, the decay of Chebyshev coefficients tells how many nodes a coordinate needs, and
///     where it is cut into elements, if need be counted from a front (stepped_grid.h). Pilots about fronts shorten the
///     step and the elements of time. Where a line is met by none, there is one round, a coarse one (and a fine one
///     where it errs by less than ten times the tolerance), and the build ends with the reason.
///  3. From some hundred trajectories, states and times are chosen between which all others are interpolated.
///  4. Cross interpolation (pgd/cross/cross_interpolation.h) of these over the grid of the coordinates; first
///     coarsely, for its pivots.
///  5. Two thousand fresh points off the grid judge all states at all times; then the certificate, as for
///     sampling. Where one of them is not satisfied, tolerances of the cross and of the nodes are lowered.
///
/// @param max_calls trajectories, those of pilots, lines and checks included
/// @param kept what an interrupted build has left, and where this one leaves its own between sweeps and rounds, until a
/// certificate refutes a field. Pilots and lines are walked again; the result is the same to the last bit
/// @returns why there is no field: where no step is short enough, or the calls end before there is one
/// @throws InputError if what was kept is no state of such a build, on this grid and at these times
Outcome<Solution> solve_by_steps(const Plan& plan, const models::ParametricModel& model, long max_calls,
                                 const ProgressCallback& progress, const CertifyClaim& certify_claim,
                                 const KeptState& kept = {});

}  // namespace samara::codebooks
