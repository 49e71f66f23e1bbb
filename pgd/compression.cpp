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

/// True if both columns (of length one) span the same line; sets the sign between them.
bool same_line(const Eigen::MatrixXd& factor, Eigen::Index a, Eigen::Index b, double& sign) {
  constexpr double kRoundOff = 1e-14;
  sign = factor.col(a).dot(factor.col(b)) < 0.0 ? -1.0 : 1.0;
  return (factor.col(a) - sign * factor.col(b)).norm() <= kRoundOff;
}

/// Adds term b to term a if they agree on all modes but at most one, which makes them one product.
bool merge(SeparatedTensor& tensor, Eigen::Index a, Eigen::Index b) {
  std::size_t different = 0;
  int count = 0;
  double sign = 1.0;
  for (std::size_t k = 0; k < tensor.factors.size(); ++k) {
    double mode_sign = 1.0;
    if (same_line(tensor.factors[k], a, b, mode_sign)) {
      sign *= mode_sign;
    } else {
      different = k;
      if (++count > 1) return false;
    }
  }
  if (count == 0) {
    tensor.weights[a] += sign * tensor.weights[b];
  } else {
    Eigen::MatrixXd& factor = tensor.factors[different];
    factor.col(a) = tensor.weights[a] * factor.col(a) + sign * tensor.weights[b] * factor.col(b);
    tensor.weights[a] = factor.col(a).norm();
    if (tensor.weights[a] > 0.0) factor.col(a) /= tensor.weights[a];
  }
  tensor.weights[b] = 0.0;
  return true;
}

/// The same tensor without terms that repeat others on all modes but one, as sums of similar tensors have
/// them.
SeparatedTensor merged(SeparatedTensor tensor) {
  tensor.normalise();
  bool changed = true;
  while (changed) {
    changed = false;
    for (Eigen::Index b = 1; b < tensor.rank(); ++b) {
      for (Eigen::Index a = 0; a < b && tensor.weights[b] != 0.0; ++a) {
        if (tensor.weights[a] != 0.0 && merge(tensor, a, b)) changed = true;
      }
    }
    tensor.normalise();
  }
  return tensor;
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
  int bound = 1;
  double chains = 1.0;
  for (const int rank : train.ranks()) {
    bound = std::max(bound, rank);
    chains *= rank;
  }
  SeparatedTensor best = merged(tensor);
  const bool expand = chains < best.rank();
  if (expand) best = to_separated(train, 0.1 * tolerance);
  const double size = norm(best);
  if (size <= tolerance) {
    best.keep({});
  } else if (best.rank() > bound) {
    EnrichResult shorter = shorter_sum(best, (expand ? 0.4 : 1.0) * tolerance / size, best.rank() - 1);
    if (shorter.termination == Termination::residual) best = std::move(shorter.solution);
  }
  best.normalise();
  const double error = distance(best, tensor);
  return {std::move(best), error, error <= tolerance};
}

}  // namespace samara::pgd
