#include "samara/pgd/tensors/compression.h"

#include <algorithm>
#include <utility>

#include "samara/pgd/tensors/separation.h"
#include "samara/pgd/tensors/tensor_train.h"

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

}  // namespace

CompressionResult compress(const SeparatedTensor& tensor, double tolerance) {
  // Rounded once while its ranks are large; what follows sees small ones.
  const TensorTrain train = rounded(to_train(tensor), 0.1 * tolerance);
  SeparatedTensor best = merged(tensor);
  if (norm(train) <= 0.9 * tolerance) {
    best.keep({});
  } else {
    const Separation separation = separate(train, 0.9 * tolerance, best.rank() - 1);
    if (separation.status == Termination::converged) best = separation.tensor;
  }
  best.normalise();
  const double error = distance(best, tensor);
  return {std::move(best), error, error <= tolerance};
}

}  // namespace samara::pgd
