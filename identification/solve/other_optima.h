#pragma once

#include <vector>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/minimize.h"

/// Internal to identification/.
namespace samara::identification {

/// Looks among the starts for optima that the captures cannot tell from the answer, and whose coefficients
/// are others. Two optima are compared by their costs, cluster by cluster: where the sum of the differences
/// is less than its standard error, from their scatter, times the one-sided 95 % quantile of Student's t,
/// other clusters of the same kind might well prefer the other one (Q. H. Vuong, Econometrica 57 (1989)
/// 307-333). With one cluster a difference counts that chi2 allows at 95 %, frames taken as independent. With several,
/// one above that counts only beside the scatter of the clusters that prefer the other optimum: one cluster that
/// excludes it by far scatters too, and is no doubt.
///
/// Starts that ended short of a minimum are taken as the optima they may become. Adds to the warnings.
/// @param residuals one per segment, joined as at the optimum; scratch
/// @param runs of the starts; `best` among them is the answer
/// @param result with its coefficients
void add_other_optima(const FitProblem& problem, std::vector<SegmentResidual>& residuals,
                      const std::vector<MinimizeResult>& runs, std::size_t best, FitResult& result);

}  // namespace samara::identification
