#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace samara::pgd {

/// Sum of products on a grid of d modes:  T(i_1, .., i_d) = sum_r weights[r] prod_k factors[k](i_k, r).
///
/// The algebraic form of a separated field, (6.10) of the dissertation: values at nodes, no axes, no units.
/// The solver works on it; a mode may be an axis or the list of outputs. Costs are stated for rank R and
/// sizes n.
struct SeparatedTensor {
  Eigen::VectorXd weights;
  std::vector<Eigen::MatrixXd> factors;  ///< per mode: size x rank

  /// The tensor without terms.
  static SeparatedTensor zero(std::span<const int> sizes);
  /// One product with weight 1.
  static SeparatedTensor product(std::vector<Eigen::VectorXd> columns);

  int rank() const { return static_cast<int>(weights.size()); }
  int modes() const { return static_cast<int>(factors.size()); }
  int size(int mode) const { return static_cast<int>(factors[static_cast<std::size_t>(mode)].rows()); }
  std::vector<int> sizes() const;

  /// @throws ArgumentError, naming `what`, if a factor has not rank() columns or an entry or weight is not
  /// finite.
  void validate(const std::string& what) const;

  /// Value at one grid point. O(R d), does not allocate.
  double entry(std::span<const int> index) const;

  /// Scales every factor column to Euclidean length 1 and the weights accordingly; terms of size zero are
  /// removed.
  void normalise();
  /// Adds scale * other (same sizes) by appending its terms. O(sum n (R + R')).
  void append(const SeparatedTensor& other, double scale = 1.0);
  /// Keeps the listed terms, in that order.
  void keep(std::span<const int> terms);
};

/// Multiplies mode k of every term by diag(scale[k]); an empty vector leaves its mode as it is.
SeparatedTensor scaled_modes(SeparatedTensor tensor, std::span<const Eigen::VectorXd> scale);

/// Euclidean inner product. O(R R' sum n).
double inner(const SeparatedTensor& a, const SeparatedTensor& b);

/// Euclidean norm through inner products: O(R^2 sum n), but a sum of terms that cancel is only resolved to
/// 1e-8 of the size of the terms. See norm() in tensor_train.h for the one without cancellation.
double fast_norm(const SeparatedTensor& tensor);

}  // namespace samara::pgd
