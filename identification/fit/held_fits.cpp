#include "samara/identification/fit/held_fits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "samara/identification/solve/minimize.h"

namespace samara::identification {

namespace {

FitPoint unpacked(const FitProblem& problem, const Eigen::VectorXd& values) {
  FitPoint point;
  const Eigen::Index shared = problem.shared_count();
  const Eigen::Index own = problem.own_count();
  point.shared = values.head(shared);
  for (std::size_t c = 0; c < problem.segments.size(); ++c)
    point.own.push_back(values.segment(shared + own * static_cast<Eigen::Index>(c), own));
  return point;
}

double cost_of(const std::optional<ProfileSolution>& solution) {
  return solution ? solution->cost : std::numeric_limits<double>::infinity();
}

}  // namespace

Eigen::VectorXd packed(const FitPoint& point) {
  Eigen::Index size = point.shared.size();
  for (const Eigen::VectorXd& own : point.own) size += own.size();
  Eigen::VectorXd values(size);
  values.head(point.shared.size()) = point.shared;
  Eigen::Index at = point.shared.size();
  for (const Eigen::VectorXd& own : point.own) {
    values.segment(at, own.size()) = own;
    at += own.size();
  }
  return values;
}

HeldFits::HeldFits(const models::TrajectoryFamily& family, const FitProblem& problem,
                   const std::vector<SegmentResidual>& like, const FitPoint& best, int held,
                   int max_iterations)
    : problem_(problem), best_(best), held_(held), max_iterations_(max_iterations) {
  problem_.shared_chart = problem.shared_chart.holding(held);
  residuals_ = make_residuals(family, problem_, like);
}

std::optional<ProfileSolution> HeldFits::solve(double value, const Eigen::VectorXd& neighbour) {
  FitPoint start = unpacked(problem_, neighbour);
  std::optional<ProfileSolution> lowest = descend(start, value);
  const auto keep_lower = [&](std::optional<ProfileSolution> other) {
    if (cost_of(other) < cost_of(lowest)) lowest = std::move(other);
  };
  if (start.own == best_.own) {
    // Beside the best answer, or nothing is own: the second start would be the first.
    if (problem_.own_count() == 0 && start.shared != best_.shared) keep_lower(descend(best_, value));
    return lowest;
  }
  const double first = cost_of(lowest);
  start.own = best_.own;
  std::optional<ProfileSolution> other = descend(std::move(start), value);
  // As far apart as descents to one minimum may end.
  const double margin = 1e-5 * first + 1e-9 * problem_.observation_count();
  const bool agree = std::isfinite(first) && std::abs(cost_of(other) - first) <= margin;
  keep_lower(std::move(other));
  if (!agree) keep_lower(descend(best_, value));
  return lowest;
}

std::optional<ProfileSolution> HeldFits::descend(FitPoint start, double value) {
  start.shared[held_] = value;
  MinimizeResult run = minimize(problem_, residuals_, std::move(start), max_iterations_);
  // Not converged: the cost is no value of the profile.
  if (run.status == Termination::max_iterations) {
    run = minimize(problem_, residuals_, std::move(run.point), 4 * max_iterations_);
  }
  if (run.status != Termination::converged) return {};
  return ProfileSolution{run.cost, packed(run.point)};
}

}  // namespace samara::identification
