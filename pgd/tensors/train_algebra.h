#pragma once

#include <string>

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/tensors/tensor_train.h"

/// Algebra of trains. All operations are exact up to round-off; ranks add or multiply, so that rounded() to a
/// tolerance should follow. Costs for ranks r, r', d modes of n nodes.
///
/// All of them throw ArgumentError naming both sides if the sizes of the operands do not match, or if a mode
/// or an index does not exist.
/// Reference: Oseledets, Tensor-train decomposition, SIAM J. Sci. Comput. 33 (2011), section 4.
namespace samara::pgd {

/// Entries of the tensor itself, as many as its grid has.
double full_size(const TensorTrain& a);

/// factor * a. O(n r).
TensorTrain scaled(TensorTrain a, double factor);

/// a + scale_b * b, of ranks r + r'. O(d n (r + r')^2).
TensorTrain sum(const TensorTrain& a, const TensorTrain& b, double scale_b = 1.0);

/// Euclidean inner product. O(d n r r' (r + r')).
double inner(const TensorTrain& a, const TensorTrain& b);

/// ||a - b||, by orthogonalisation: accurate to round-off of a and b. O(d n (r + r')^3).
double distance(const TensorTrain& a, const TensorTrain& b);

/// Entry by entry a * b, of ranks r r'. O(d n r^2 r'^2).
TensorTrain hadamard(const TensorTrain& a, const TensorTrain& b);

/// The same rounded to `tolerance` (absolute, Euclidean norm). The product is orthogonalised as it is formed,
/// so that its cores of r^2 r'^2 n entries never exist: O(d n s r r' (r + r' + s)) for ranks s <= r r' of the
/// product before it is rounded.
TensorTrain rounded_hadamard(const TensorTrain& a, const TensorTrain& b, double tolerance);

/// sum_i weights[i] a(.., i, ..) over one mode, which goes. O(n r^2).
/// @throws ArgumentError also if it is the only mode: inner products give numbers.
TensorTrain contracted(const TensorTrain& a, int mode, const Eigen::VectorXd& weights);

/// a at one index of a mode, which goes. O(r^3).
/// @throws ArgumentError also if it is the only mode: see TensorTrain::entry().
TensorTrain restricted(const TensorTrain& a, int mode, int index);

/// A matrix (rows x size of the mode) applied to one mode. Ranks stay. O(r^2 times the entries of the
/// matrix).
TensorTrain applied(TensorTrain a, int mode, const SparseMatrix& matrix);
TensorTrain applied(TensorTrain a, int mode, const Eigen::MatrixXd& matrix);

}  // namespace samara::pgd
