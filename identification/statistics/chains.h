#pragma once

#include <Eigen/Core>

/// What draws of several Markov chains are worth. A. Gelman and others, Bayesian Data Analysis, 3rd ed. (2013),
/// sections 11.4 and 11.5: every chain is split in two, so that one that drifts disagrees with itself.
namespace samara::identification {

struct ChainSummary {
  /// sqrt of the variance of all draws over that within half chains: 1 where chains agree; above 1.01 they do not;
  /// infinite where none moved.
  double rhat = 0.0;
  /// Independent draws whose mean would be as good. Chains that turn back and forth may be worth more than their
  /// number.
  double effective = 0.0;
};

/// @param draws of one quantity: draws x chains, at least 4 x 1
ChainSummary summarize_chains(const Eigen::MatrixXd& draws);

}  // namespace samara::identification
