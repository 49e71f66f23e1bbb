#pragma once

#include <string>

#include "samara/pgd/tensors/separated_tensor.h"

namespace samara::pgd {

struct CompressionResult {
  SeparatedTensor tensor;
  double error = 0.0;          ///< ||tensor - original||, measured, Euclidean
  bool tolerance_met = false;  ///< error <= tolerance
};

/// The same tensor with fewer terms, to an absolute tolerance in the Euclidean norm.
///
/// Terms that differ on one mode only are put together. The tensor's train is rounded by singular values,
/// which is safe and gives a lower bound for the number of terms, its largest rank; a shorter sum is then
/// looked for by separate() in separation.h: the expansion of the train, or alternating least squares against
/// it. With two modes of more than one node the result is optimal (the singular value decomposition) within
/// the share of the tolerance. The result has at most as many terms as the tensor.
///
/// O(d n R^3) for the train, then for every number of terms r tried O(sweeps d n (r s^2 + r^2)) with the
/// ranks s of the train.
CompressionResult compress(const SeparatedTensor& tensor, double tolerance);

}  // namespace samara::pgd
