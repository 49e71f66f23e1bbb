#include "samara/pgd/compression.h"

#include <algorithm>
#include <utility>

#include "samara/pgd/enrichment.h"
#include "samara/pgd/tensor_train.h"

namespace samara::pgd {

namespace {

double distance(const SeparatedTensor& a, const SeparatedTensor& b) {
  SeparatedTensor difference = a;
  difference.append(b, -1.0);
  return norm(difference);
}

/// Least squares with growing rank; gives up at `max_rank` terms.
EnrichResult shorter_sum(const SeparatedTensor& target, double relative_tolerance, int max_rank) {
  LinearProblem problem;
  std::vector<ModeOperator> identity;
  for (int k = 0; k < target.modes(); ++k) identity.push_back(ModeOperator::identity(target.size(k)));
  problem.op.terms.push_back(std::move(identity));
  problem.rhs = target;
  // Galerkin with the identity is least squares, without squaring any condition number.
  EnrichOptions options;
  options.projection = Projection::galerkin;
  options.residual_tolerance = relative_tolerance;
  options.max_rank = max_rank;
  options.update_sweeps = 4;
  return enrich(problem, options);
}

}  // namespace

CompressionResult compress(const SeparatedTensor& tensor, double tolerance) {
  const TensorTrain train = rounded(to_train(tensor), 0.5 * tolerance);
  const std::vector<int> ranks = train.ranks();
  const int bound = ranks.empty() ? 1 : *std::max_element(ranks.begin(), ranks.end());
  SeparatedTensor best = to_separated(train, 0.1 * tolerance);
  const double size = norm(best);
  if (best.rank() > bound && size > 0.0) {
    EnrichResult shorter = shorter_sum(best, std::min(0.4 * tolerance / size, 1.0), best.rank() - 1);
    if (shorter.termination == Termination::residual) best = std::move(shorter.solution);
  }
  best.normalise();
  const double error = distance(best, tensor);
  return {std::move(best), error, error <= tolerance};
}

}  // namespace samara::pgd
