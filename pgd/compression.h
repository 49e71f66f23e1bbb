#pragma once

#include <string>

#include "samara/pgd/separated_tensor.h"

namespace samara::pgd {

struct CompressionResult {
  SeparatedTensor tensor;
  double error = 0.0;          ///< ||tensor - original||, measured, Euclidean
  bool tolerance_met = false;  ///< error <= tolerance
};

/// The same tensor with fewer terms, to an absolute tolerance in the Euclidean norm.
///
/// First the train of the tensor is rounded by singular values, which is safe and gives a lower bound for the
/// number of terms: the largest train rank. Its expansion and the tensor itself, terms that differ on one
/// mode only put together, are two candidates; if the shorter one has more terms than the bound, enrichment
/// with the identity as operator (least squares, all factors updated) looks for a still shorter sum. With two
/// modes of more than one node the result is optimal (the singular value decomposition). O(d n R^3) for the
/// train, then O(sweeps d n r^2 (r + R)) per term.
CompressionResult compress(const SeparatedTensor& tensor, double tolerance);

}  // namespace samara::pgd
