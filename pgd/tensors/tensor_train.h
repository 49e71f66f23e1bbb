#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/tensors/separated_tensor.h"

namespace samara::pgd {

/// One core of a train: entries (l, i, r) in memory at l + left (i + size r), so that both unfoldings are
/// views.
struct TrainCore {
  int left = 1;
  int size = 0;
  int right = 1;
  Eigen::VectorXd data;

  TrainCore() = default;
  TrainCore(int left_rank, int mode_size, int right_rank)
      : left(left_rank),
        size(mode_size),
        right(right_rank),
        data(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(left_rank) * mode_size * right_rank)) {}

  using Map = Eigen::Map<Eigen::MatrixXd>;
  using ConstMap = Eigen::Map<const Eigen::MatrixXd>;
  /// (left size) x right
  Map left_unfolding() { return {data.data(), Eigen::Index{left} * size, right}; }
  ConstMap left_unfolding() const { return {data.data(), Eigen::Index{left} * size, right}; }
  /// left x (size right)
  Map right_unfolding() { return {data.data(), left, Eigen::Index{size} * right}; }
  ConstMap right_unfolding() const { return {data.data(), left, Eigen::Index{size} * right}; }
  /// left x right, at one index of the mode
  Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> slice(int i) const {
    return {data.data() + Eigen::Index{left} * i, left, right,
            Eigen::OuterStride<>(Eigen::Index{left} * size)};
  }
};

/// Tensor train: T(i_1..i_d) = G_1(i_1) G_2(i_2) .. G_d(i_d), the first and last rank being 1.
/// Reference: Oseledets, Tensor-train decomposition, SIAM J. Sci. Comput. 33 (2011).
struct TensorTrain {
  std::vector<TrainCore> cores;

  int modes() const { return static_cast<int>(cores.size()); }
  /// Ranks between neighbouring modes, modes() - 1 of them.
  std::vector<int> ranks() const;
  double entry(std::span<const int> index) const;
};

/// The same tensor as a train, its cores but the last orthonormal; ranks are at most the number of terms.
/// O(d n R^3) for R terms.
TensorTrain to_train(const SeparatedTensor& tensor);

/// All entries of a tensor as a train, by singular values: the result differs by at most `tolerance` (absolute,
/// Euclidean norm). Reference: Oseledets 2011, algorithm 1, from the last mode on.
/// @param values rows: the first mode; columns: the other modes, the first of them fastest
/// @param sizes of these other modes, at least one
/// @throws ArgumentError if the columns are not as many as the sizes say.
TensorTrain to_train(const Eigen::MatrixXd& values, const std::vector<int>& sizes, double tolerance);

/// Rounding by singular values: the result differs by at most `tolerance` (absolute, Euclidean norm) and has
/// the smallest ranks up to a factor sqrt(d - 1) in the tolerance. O(d n r^3).
TensorTrain rounded(TensorTrain train, double tolerance);

/// The same of a train whose cores but the last are orthonormal already (left unfoldings).
TensorTrain cut_ranks(TensorTrain train, double tolerance);

/// Euclidean norm by orthogonalisation: accurate to round-off of the train itself.
double norm(const TensorTrain& train);
/// Euclidean norm of a sum of products to eight digits or better, also where terms cancel: by inner products
/// where they resolve it, O(R^2 sum n), else by orthogonalisation, O(d n R^3).
double norm(const SeparatedTensor& tensor);

/// The same tensor as a sum of products, one for every chain of ranks, the smallest products left out as long
/// as their norms sum to at most `tolerance` (absolute). The chains are formed before any is left out, which
/// explodes with many modes: separate() in separation.h does the same with a bound on the terms.
/// O(chains d n).
/// @throws ArgumentError if there are more than kMaxChains chains.
SeparatedTensor to_separated(const TensorTrain& train, double tolerance = 0.0);

/// The most products that to_separated() forms.
inline constexpr int kMaxChains = 200'000;

}  // namespace samara::pgd
