#pragma once

#include <string>

#include "samara/base/termination.h"
#include "samara/pgd/tensors/separated_tensor.h"
#include "samara/pgd/tensors/tensor_train.h"

namespace samara::pgd {

struct Separation {
  SeparatedTensor tensor;  ///< normalised
  /// converged; rank_limit: no sum of the allowed number of terms was found, the best one is returned.
  Termination status = Termination::rank_limit;
  std::string message = "separate() was not called";
  double error = 0.0;     ///< ||tensor - train||, measured, Euclidean
  double chains = 0.0;    ///< products in the full expansion of the train after rounding
  bool expanded = false;  ///< the sum is the (pruned) expansion, not a least-squares fit
};

/// A train as a sum of products, with a bound on the number of terms.
///
/// The product of all ranks counts the terms of the full expansion, 20^4 with five modes at ranks of 20:
/// it is never formed unless it has at most `max_terms` terms. First the train is rounded. Its expansion is
/// followed chain by chain from the left; with the cores after orthonormal, what a beginning of a chain
/// contributes is known before it is followed, and beginnings that do not matter within the tolerance are
/// dropped whole. Least squares look for a shorter sum, up to kMaxFittedTerms terms (more would cost more
/// than they save); the shorter of the two is returned. If neither is within `max_terms`, the status says so.
///
/// Cost for ranks r: rounding O(d n r^3), expansion O(terms d (n + r)), fit O(sweeps d n (R r^2 + R^2)) per
/// number of terms R tried.
/// @param tolerance absolute, Euclidean norm, at least 0
/// @throws ArgumentError if the train has no modes, the tolerance is negative or NaN, or max_terms is
/// negative.
Separation separate(const TensorTrain& train, double tolerance, int max_terms = 2000);

/// The most terms that separate() looks for by least squares.
inline constexpr int kMaxFittedTerms = 80;

}  // namespace samara::pgd
