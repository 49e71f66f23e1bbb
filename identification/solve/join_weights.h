#pragma once

#include <optional>
#include <vector>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"

/// Internal to identification/.
namespace samara::identification {

/// How well a segment alone determines its start, per direction of the own unknowns in the order of the
/// joins: the median over segments of the standard deviations from their own frames, the shared unknowns
/// held. What frames say nothing of is known to its box, an attitude to half a turn. Empty where a residual of
/// a segment or its derivative is not finite, as without a trajectory: boxes alone would make joins so loose that
/// segments part.
/// @param residuals scratch
std::optional<Eigen::VectorXd> start_deviations(const FitProblem& problem,
                                                std::vector<SegmentResidual>& residuals,
                                                const FitPoint& point);

}  // namespace samara::identification
