#include "samara/pgd/evolution/march_context.h"

#include <algorithm>
#include <utility>

namespace samara::pgd {

namespace {

/// Of the tolerance of a slab, what iterations may leave.
constexpr double kIterationShare = 0.01;

}  // namespace

MarchContext::MarchContext(const AdaptiveProblem& problem, const SlabOptions& options,
                           const Eigen::VectorXd& scales, LocalTolerance tolerance)
    : problem_(problem),
      options_(options),
      scales_(scales),
      tolerance_(tolerance.wanted),
      most_lenient_(std::max(1.0, tolerance.largest / tolerance.wanted)),
      collocation_(*problem.system, scales, options.time_points) {}

SlabPoints MarchContext::solve(const std::vector<double>& borders, const Eigen::MatrixXd& start,
                               const Eigen::MatrixXd& q) {
  SlabPoints points = collocation_.solve(borders, start, q, kIterationShare * tolerance_);
  evaluations_ += points.evaluations;
  return points;
}

long MarchContext::take_evaluations() {
  return std::exchange(evaluations_, 0);
}

}  // namespace samara::pgd
