#pragma once

#include <vector>

#include "samara/base/termination.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/segment_residual.h"

/// Internal to identification/.
namespace samara::identification {

/// Draws of all unknowns, shared and own, from
///
///     exp(-cost of the captures/dispersion - cost of priors and joins)
///
/// in the box: the loss as a likelihood, with the noise that the residuals show at the answer. Where nothing was
/// known of an unknown beforehand, its values in the box are equally likely: those of its logarithm, if it moves by
/// factors; all attitudes, if it is one.
///
/// Hamiltonian Monte Carlo (S. Duane and others, Phys. Lett. B 195 (1987) 216-222; R. Neal, Handbook of Markov
/// chain Monte Carlo (2011), ch. 5): four chains, each with a stream of random numbers of its own, in
/// directions in which the curvature at the answer, and then the draws of the warm-up, have a deviation of one.
/// Walls of the box are mirrors (Neal, section 5.5.1.5). Unknowns move as their charts say: a step and the one
/// back are inverse to each other and keep volumes on the group, so that the leapfrog is exact for attitudes
/// too, but for its energy. Steps are set in a warm-up that is left out (M. D. Hoffman and A. Gelman, J. Mach.
/// Learn. Res. 15 (2014) 1593-1623, section 3.2).
///
/// @param residuals one per segment, joined as at the answer
/// @param point the answer  @param dispersion of Uncertainty
/// @returns no posterior where the residuals leave no noise, nothing or too much is unknown, or the answer is no
///   minimum inside the box
Outcome<Posterior> sample_posterior(const models::TrajectoryFamily& family, const FitProblem& problem,
                                    const std::vector<SegmentResidual>& residuals, const FitPoint& point,
                                    double dispersion, const PosteriorOptions& options);

}  // namespace samara::identification
