#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/statistics/profile.h"

/// Internal to identification/.
namespace samara::identification {

/// Shared unknowns, then each segment's own, in one vector.
Eigen::VectorXd packed(const FitPoint& point);

/// Fits with one shared unknown held: the points of its profile. A descent from the neighbouring point alone stays in
/// the valley in which the profile began to climb. So each point is reached from the neighbour's answer, and from there
/// with the own unknowns of the best answer; where these two end apart, from the best answer as a whole. The lowest
/// counts. Owns its residuals: one per thread.
class HeldFits {
 public:
  /// @param best the answer of the fit  @param like residuals whose weights at joins are taken over
  HeldFits(const models::TrajectoryFamily& family, const FitProblem& problem,
           const std::vector<SegmentResidual>& like, const FitPoint& best, int held, int max_iterations);
  // Residuals point to the problem.
  HeldFits(const HeldFits&) = delete;
  HeldFits& operator=(const HeldFits&) = delete;

  /// @param neighbour packed answer of a neighbouring point  @returns nothing if no descent converged
  std::optional<ProfileSolution> solve(double value, const Eigen::VectorXd& neighbour);

  long evaluations() const { return evaluations_of(residuals_); }

 private:
  std::optional<ProfileSolution> descend(FitPoint start, double value);

  FitProblem problem_;
  std::vector<SegmentResidual> residuals_;
  const FitPoint& best_;
  int held_;
  int max_iterations_;
};

}  // namespace samara::identification
