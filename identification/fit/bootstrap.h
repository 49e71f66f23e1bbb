#pragma once

#include <vector>

#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/segment_residual.h"

/// Internal to identification/.
namespace samara::identification {

/// Errors of the coefficients from their scatter over fits in which each cluster of captures counts with a
/// random weight, drawn from the exponential distribution and divided by the mean: the bootstrap over
/// clusters as D. B. Rubin, Ann. Statist. 9 (1981) 130-134, has it. Drawing clusters with replacement gives
/// weights 0, 1, 2, .. with the same first two moments for many clusters; here none is ever left out, so
/// that what one cluster alone determines stays determined, and each fit starts at the answer with all start
/// states found. Other optima are not looked for.
///
/// To first order replicates scatter by C/(C + 1) H^-1 (sum_c g_c g_c^T) H^-1, C clusters; errors are widened
/// by sqrt((C + 1)/(C - 1)) to mean what the clustered ones in fit.h mean.
///
/// Priors of coefficients are observations too: each fit has their means drawn anew, from their own
/// distributions, so that what a prior alone holds scatters by its deviation.
///
/// A coefficient at a bound has no error (NaN). For fewer than two clusters a warning is all that is added.
/// Every replicate has a stream of random numbers of its own: it is the same alone, and on any number of threads.
/// @param residuals one per segment, joined as at the answer
/// @param point the answer
/// @param result with its coefficients
void add_bootstrap(const models::TrajectoryFamily& family, const FitProblem& problem,
                   const std::vector<SegmentResidual>& residuals, const FitPoint& point,
                   const FitOptions& options, FitResult& result);

}  // namespace samara::identification
