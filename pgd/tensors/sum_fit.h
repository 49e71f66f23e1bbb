#pragma once

#include "samara/pgd/tensors/separated_tensor.h"
#include "samara/pgd/tensors/tensor_train.h"

namespace samara::pgd {

struct SumFitOptions {
  double tolerance = 0.0;  ///< absolute, Euclidean norm
  int start_rank = 1;      ///< a lower bound of the rank: shorter sums are not worked out
  int max_rank = 1;
  int max_sweeps = 200;  ///< with one number of terms
};

struct SumFit {
  SeparatedTensor tensor;  ///< normalised
  double error = 0.0;      ///< ||tensor - target||, Euclidean
  bool met = false;        ///< error <= tolerance
};

/// The shortest sum of products that alternating least squares find within a tolerance of a train.
///
/// All factors of one mode after the other are the least-squares solution for the others given, back and
/// forth over the modes; sweeps end as soon as they no longer pay, then the best product for what is left is
/// added as a term; when the error falls too slowly to meet the tolerance with the terms allowed, the search
/// ends. Once the tolerance is met, the smallest terms are tried without. One sweep costs
/// O(d n (R r^2 + R^2) + d R^3) for R terms and ranks r of the train.
SumFit fit_sum(const TensorTrain& target, const SumFitOptions& options);

}  // namespace samara::pgd
