#include "samara/pgd/evolution/march_context.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "samara/pgd/tensors/train_algebra.h"

namespace samara::pgd {

namespace {

/// Of the tolerance of a slab, what iterations may leave.
constexpr double kIterationShare = 0.01;
/// And what rounding may leave out.
constexpr double kRoundingShare = 0.3;
/// Largest over root mean square of that.
constexpr double kPeak = 4.0;
/// Of the whole time: the longest slabs.
constexpr double kLargestSlab = 0.125;
/// And the shortest elements that are tried.
constexpr double kLeastSlab = 2e-4;

}  // namespace

MarchContext::MarchContext(const AdaptiveProblem& problem, const SlabOptions& options,
                           const SlabSolver& solver, const Eigen::VectorXd& scales, LocalTolerance tolerance)
    : problem_(problem),
      options_(options),
      solver_(solver),
      scales_(scales),
      start_sizes_(pgd::start_sizes(problem).cwiseQuotient(scales)),
      tolerance_(tolerance.wanted),
      most_lenient_(std::max(1.0, tolerance.largest / tolerance.wanted)),
      collocation_(*problem.system, scales, kTimePoints) {}

double MarchContext::longest() const {
  return kLargestSlab * problem_.end;
}

double MarchContext::shortest() const {
  return kLeastSlab * problem_.end;
}

double MarchContext::rounding(const SlabCell& cell, const TensorTrain& train) const {
  return kRoundingShare / kPeak * cell.leniency * tolerance_ * std::sqrt(full_size(train));
}

bool MarchContext::is_cancelled(std::optional<Progress> stage) {
  if (stage) stage_ = std::move(*stage);
  return options_.progress && !options_.progress(stage_);
}

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
