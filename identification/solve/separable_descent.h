#pragma once

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/minimize.h"

/// Internal to identification/.
namespace samara::identification {

/// The minimum of a cost whose motions are coupled by shared unknowns alone: variable projection (G. Golub,
/// V. Pereyra, Inverse Problems 19 (2003) R1-R26). The shared unknowns take damped steps on the cost with
/// each motion's own unknowns minimised, which follow every step to first order and are then settled, motion
/// by motion, each with a damping of its own: one span in a narrow valley does not shorten the steps of the
/// others.
///
/// Where residuals are large, J^T J lacks much of the Hessian, and Gauss-Newton converges slowly. What it
/// lacks is learned from the steps, as NL2SOL does (J. E. Dennis, D. M. Gay, R. E. Welsch, ACM Trans. Math.
/// Softw. 7 (1981) 348-368), for the shared unknowns and for each motion.
///
/// It ends where no step would move an unknown by more than a share of its naive standard error (D. M. Bates,
/// D. G. Watts, Technometrics 23 (1981) 179-183): with the gradient g, the Hessian H and the dispersion d of
/// the residuals, where g^T H^-1 g <= share^2 d, for the own unknowns of each motion and for the shared ones.
/// Where nothing is left over, it ends at the limits of rounding.
///
/// @param max_iterations steps of the shared unknowns; of own ones, if nothing is shared
/// @returns failed where a residual or a slope is not finite at the start, as without a trajectory
/// @throws what a trajectory source throws
MinimizeResult minimize_separably(const FitProblem& problem, std::vector<SegmentResidual>& residuals,
                                  FitPoint start, int max_iterations, double share);

}  // namespace samara::identification
