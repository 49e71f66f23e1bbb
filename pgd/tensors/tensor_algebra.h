#pragma once

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/tensors/separated_tensor.h"

/// Algebra of sums of products on a grid. All operations are exact up to round-off; those that multiply the
/// number of terms are meant to be followed by compress(). Costs for ranks R, R', modes of n nodes, d modes.
///
/// All of them throw ArgumentError naming both sides if the sizes of the operands do not match, or if a mode
/// or an index does not exist.
namespace samara::pgd {

/// factor * a. O(R).
SeparatedTensor scaled(SeparatedTensor a, double factor);

/// a + scale_b * b, with R + R' terms. O(d n (R + R')).
SeparatedTensor sum(SeparatedTensor a, const SeparatedTensor& b, double scale_b = 1.0);

/// Entry by entry a * b, with R R' terms. O(d n R R').
SeparatedTensor hadamard(const SeparatedTensor& a, const SeparatedTensor& b);

/// sum_i weights[i] a(.., i, ..) over one mode, which goes: interpolation and quadrature are of this kind.
/// Rank R. O(n R). A tensor of one mode becomes one without modes, whose only entry is the sum of its
/// weights.
SeparatedTensor contracted(SeparatedTensor a, int mode, const Eigen::VectorXd& weights);

/// a at one index of a mode, which goes. O(R).
SeparatedTensor restricted(SeparatedTensor a, int mode, int index);

/// A matrix (rows x size of the mode) applied to one mode. Rank R. O(R times the entries of the matrix).
SeparatedTensor applied(SeparatedTensor a, int mode, const SparseMatrix& matrix);
SeparatedTensor applied(SeparatedTensor a, int mode, const Eigen::MatrixXd& matrix);

}  // namespace samara::pgd
