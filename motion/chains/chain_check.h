#pragma once

#include <limits>

#include "samara/motion/chains/markov_chain.h"

/// What a chain is worth on sequences that it was not made of, and where chains end.
namespace samara::motion {

/// Lengths of uninterrupted runs of a symbol, those that begin or end a sequence left out: how many have 1, 2, 3, 4,
/// and more symbols.
Eigen::VectorXd run_lengths(const std::vector<std::vector<int>>& sequences, int symbol);

struct ChainCheck {
  double log_likelihood = 0.0;  ///< per symbol
  /// Of the run lengths of each symbol, against those of the chain; NaN where fewer than 25 runs were seen, or where
  /// hardly any but of one length are expected.
  Eigen::VectorXd chi_square;
  /// Degrees of freedom of each: 4, less where lengths are taken together to expect 5 runs of each; 0 where it is NaN.
  Eigen::VectorXi freedom;
  /// The 95 % point of the largest of them if the chain is exact; NaN if all are. The error of a chain that was fitted
  /// to as many sequences raises it, at most to twice that.
  double largest_95 = std::numeric_limits<double>::quiet_NaN();
  /// Largest difference between the share of k two symbols after i, as seen, and that of the chain, in standard errors
  /// of the share seen.
  double two_steps = 0.0;
};

/// The chain's own runs and double steps are those of a hundred drawn sequences for each, as long as it is.
ChainCheck check(const MarkovChain& chain, const std::vector<std::vector<int>>& sequences,
                 std::uint64_t seed = 1);

/// From where a chain begins until it comes to a state in which it ends.
struct Absorption {
  std::vector<int> transient;   ///< states in which it does not end
  Eigen::MatrixXd fundamental;  ///< (I - Q)^-1: expected visits, from and to transient states
  Eigen::VectorXd times;        ///< expected steps, per transient state
};

/// @param absorbing per state, whether the chain ends there
/// @throws ArgumentError for what is no matrix of probabilities (its rows sum to 1 within 0.01), or a state from which
/// no end is ever reached.
Absorption absorption(const Eigen::Ref<const Eigen::MatrixXd>& probability,
                      const std::vector<bool>& absorbing);

}  // namespace samara::motion
