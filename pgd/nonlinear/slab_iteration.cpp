#include "samara/pgd/nonlinear/slab_iteration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Last correction, or what is left after it, over the tolerance: both are root mean squares.
constexpr double kCorrectionShare = 0.3;
/// Corrections of so many scales belong to no solution.
constexpr double kLargest = 1e4;
constexpr int kDefectNodes = 128;

/// At random nodes: what the iteration and crosses leave.
double defect_on_grid(const StrategySlab& slab, const TensorTrain& solution) {
  const IndexBatch entries = slab.random_entries(kDefectNodes);
  return defect_at(slab, slab.parameters_at(entries), values_at(solution, entries));
}

void raise(std::vector<int>& largest, const std::vector<int>& ranks) {
  largest.resize(ranks.size(), 0);
  for (std::size_t k = 0; k < ranks.size(); ++k) largest[k] = std::max(largest[k], ranks[k]);
}

}  // namespace

double defect_at(const StrategySlab& slab, const Eigen::MatrixXd& q, const Eigen::MatrixXd& x) {
  const Eigen::MatrixXd f = slab.rates(x.bottomRows(slab.rows()), q);
  double largest = 0.0;
  for (Eigen::Index j = 0; j < q.cols(); ++j) {
    Eigen::MatrixXd rest = f.col(j).reshaped(slab.states(), slab.points()) * slab.integration().transpose();
    rest.colwise() += x.col(j).head(slab.states());
    const Eigen::VectorXd defect = rest.reshaped() - x.col(j).tail(slab.rows());
    if (!defect.allFinite()) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, defect.cwiseAbs().maxCoeff());
  }
  return largest;
}

void SlabIteration::first_iterate(Strategy& strategy, int iterations) {
  bool fails = strategy.begin(slab_).has_value();
  for (int k = 0; k < iterations && !fails; ++k) fails = !step(strategy);
  if (fails) iterate_ = slab_.constant();
  record_ = {};
}

std::optional<Ending> SlabIteration::run(Strategy& strategy) {
  if (std::optional<Ending> failure = strategy.begin(slab_)) return failure;
  const int most = std::min(options_.max_iterations, strategy.max_iterations());
  double correction = 0.0;
  while (record_.iterations < most) {
    if (std::optional<Ending> reason = reason_to_stop()) return reason;
    const Outcome<double> corrected = step(strategy);
    if (!corrected) return corrected.ending();
    correction = *corrected;
    ++record_.iterations;
    if (converged(correction)) return std::nullopt;
    if (diverges(strategy, correction)) {
      return ended(Termination::diverged,
                   fmt::format("{} after {} iterations, the last correction is {:.3g} of the scales",
                               strategy.on_divergence(ratio_), record_.iterations, correction));
    }
  }
  return ended(Termination::max_iterations,
               fmt::format("{} iterations leave a correction of {:.3g} of the scales", record_.iterations,
                           correction));
}

std::optional<Ending> SlabIteration::reason_to_stop() const {
  if (options_.progress && !options_.progress({fmt::format("slab {}", slab_.number() + 1), fraction()}))
    return ended(Termination::cancelled, "cancelled");
  const long used = options_.evaluations_before + counts_.rhs + counts_.jacobian;
  if (options_.max_evaluations == 0 || used < options_.max_evaluations) return std::nullopt;
  return ended(
      Termination::max_calls,
      fmt::format("the {} evaluations of f and its Jacobian allowed are used up", options_.max_evaluations));
}

/// @returns the correction
Outcome<double> SlabIteration::step(Strategy& strategy) {
  const std::optional<double> last =
      record_.corrections.empty() ? std::nullopt : std::optional(record_.corrections.back());
  const Outcome<LinearSlab> linear = strategy.linearise(slab_, iterate_, last);
  if (!linear) return linear.ending();
  rough_ = linear->rough;
  raise(record_.source_ranks, linear->source.ranks());
  if (linear->jacobian) raise(record_.jacobian_ranks, linear->jacobian->ranks());
  Outcome<TensorTrain> next = strategy.solution(slab_, *linear, last, pivots_);
  if (!next) return next.ending();
  const double correction = distance(*next, iterate_) / std::sqrt(full_size(*next));
  iterate_ = std::move(*next);
  record_.corrections.push_back(correction);
  return correction;
}

bool SlabIteration::converged(double correction) {
  const std::vector<double>& all = record_.corrections;
  const double enough = kCorrectionShare * slab_.tolerance();
  ratio_ = all.size() > 1 ? correction / all[all.size() - 2] : 0.0;
  if (correction <= enough) return !rough_;
  record_.contraction = std::max(record_.contraction, ratio_);
  // What is left of a contracting iteration is about ratio / (1 - ratio) of its last correction; but where
  // a separated Jacobian is wrong in a corner of the box, it is more there. The equations tell.
  return !rough_ && all.size() > 1 && ratio_ < 0.5 && correction * ratio_ <= 0.5 * enough &&
         defect_on_grid(slab_, iterate_) <= slab_.tolerance();
}

bool SlabIteration::diverges(const Strategy& strategy, double correction) {
  growths_ = ratio_ > 1.0 ? growths_ + 1 : 0;
  return !(correction < kLargest) || growths_ >= strategy.patience();
}

Ending SlabIteration::ended(Termination status, const std::string& why) const {
  return {status, fmt::format("between t = {:.6g} and {:.6g}: {}", slab_.begin(),
                              slab_.begin() + slab_.length(), why)};
}

double SlabIteration::fraction() const {
  const Axis& time = slab_.problem().time;
  return (slab_.begin() - time.lower()) / time.length();
}

}  // namespace samara::pgd
