#pragma once

#include "samara/motion/chains/markov_chain.h"

/// What a chain is worth on sequences that it was not made of, and where chains end.
namespace samara::motion {

/// Lengths of uninterrupted runs of a symbol, those that begin or end a sequence left out: how many have 1, 2, 3, 4,
/// and more symbols.
Eigen::VectorXd run_lengths(const std::vector<std::vector<int>>& sequences, int symbol);

struct ChainCheck {
  double log_likelihood = 0.0;  ///< per symbol
  /// Of the run lengths of each symbol, against those of the chain: 4 degrees of freedom (their 95 % point is 9.49);
  /// NaN where fewer than 25 runs were seen.
  Eigen::VectorXd chi_square;
  /// Largest difference between the share of k two symbols after i, as seen, and that of the chain, in standard errors
  /// of the share seen.
  double two_steps = 0.0;
};

/// The chain's own runs and double steps are those of a hundred times as many symbols, drawn.
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
