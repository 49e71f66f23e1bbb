#pragma once

#include <Eigen/Core>

#include "samara/base/progress.h"
#include "samara/motion/sweeps/sweep_plan.h"

namespace samara::motion {

/// Largest Lyapunov exponents [1/s] of falls, from the settling time of the plan to its end: the growth of a tangent of
/// the trajectory, of unit size in each state's own scale, places left out. In space the disturbance is a rate about
/// the axis of the release, so that a motion in a plane is disturbed within its plane: out of it all are unstable.
/// NaN where a fall or its tangent is not finite.
/// @param points per fall, as SweepPlan::lane_points() gives them; @param first number of the first of them
Eigen::VectorXd lyapunov_exponents(const SweepPlan& plan, const Eigen::MatrixXd& points, Eigen::Index first,
                                   int threads, const ProgressCallback& progress);

}  // namespace samara::motion
