#include "samara/motion/chains/chain_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::motion {

namespace {

constexpr Eigen::Index kLengths = 5;  // 1, 2, 3, 4, and more

/// Shares of k two symbols after i; columns of i that were not seen are zero. `seen` counts them.
Eigen::MatrixXd double_steps(const std::vector<std::vector<int>>& sequences, int symbols,
                             Eigen::VectorXd& seen) {
  Eigen::MatrixXd counts = Eigen::MatrixXd::Zero(symbols, symbols);
  for (const std::vector<int>& sequence : sequences) {
    for (std::size_t k = 2; k < sequence.size(); ++k) counts(sequence[k - 2], sequence[k]) += 1.0;
  }
  seen = counts.rowwise().sum();
  for (Eigen::Index i = 0; i < symbols; ++i) {
    if (seen[i] > 0.0) counts.row(i) /= seen[i];
  }
  return counts;
}

}  // namespace

Eigen::VectorXd run_lengths(const std::vector<std::vector<int>>& sequences, int symbol) {
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(kLengths);
  for (const std::vector<int>& sequence : sequences) {
    std::size_t begin = 0;
    for (std::size_t k = 1; k < sequence.size(); ++k) {
      if (sequence[k] == sequence[k - 1]) continue;
      if (begin > 0 && sequence[begin] == symbol)
        counts[std::min(static_cast<Eigen::Index>(k - begin), kLengths) - 1] += 1.0;
      begin = k;
    }
  }
  return counts;
}

ChainCheck check(const MarkovChain& chain, const std::vector<std::vector<int>>& sequences,
                 std::uint64_t seed) {
  ChainCheck result;
  result.log_likelihood = chain.log_likelihood(sequences, static_cast<std::size_t>(chain.order()));
  constexpr int kTimes = 100;
  std::vector<std::vector<int>> drawn;
  for (std::size_t n = 0; n < sequences.size(); ++n) {
    Stream stream(seed, n);
    drawn.push_back(chain.draw_sequence(kTimes * sequences[n].size(), stream));
  }
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  result.chi_square.setConstant(chain.symbols(), unknown);
  for (int symbol = 0; symbol < chain.symbols(); ++symbol) {
    const Eigen::VectorXd seen = run_lengths(sequences, symbol), own = run_lengths(drawn, symbol);
    if (seen.sum() < 25.0 || own.sum() == 0.0) continue;
    // Lengths that the chain hardly draws count as half a run of it.
    const Eigen::VectorXd expected = (own * (seen.sum() / own.sum())).cwiseMax(0.5);
    result.chi_square[symbol] = ((seen - expected).array().square() / expected.array()).sum();
  }
  Eigen::VectorXd seen, ignored;
  const Eigen::MatrixXd shares = double_steps(sequences, chain.symbols(), seen);
  const Eigen::MatrixXd own = double_steps(drawn, chain.symbols(), ignored);
  for (Eigen::Index i = 0; i < shares.rows(); ++i) {
    if (seen[i] == 0.0) continue;
    for (Eigen::Index k = 0; k < shares.cols(); ++k) {
      const double p = std::clamp(own(i, k), 1.0 / (seen[i] + 1.0), 1.0 - 1.0 / (seen[i] + 1.0));
      result.two_steps =
          std::max(result.two_steps, std::abs(shares(i, k) - own(i, k)) / std::sqrt(p * (1.0 - p) / seen[i]));
    }
  }
  return result;
}

Absorption absorption(const Eigen::Ref<const Eigen::MatrixXd>& probability,
                      const std::vector<bool>& absorbing) {
  const Eigen::Index size = probability.rows();
  if (size != probability.cols() || static_cast<Eigen::Index>(absorbing.size()) != size)
    throw ArgumentError(
        fmt::format("probabilities of {} x {} states and ends for {} were given, expected as many", size,
                    probability.cols(), absorbing.size()));
  for (Eigen::Index i = 0; i < size; ++i) {
    const double sum = probability.row(i).sum();
    if (!(probability.row(i).minCoeff() >= 0.0) || !(std::abs(sum - 1.0) <= 0.01))
      throw ArgumentError(fmt::format("the probabilities from state {} sum to {}, expected 1", i, sum));
  }
  Absorption result;
  for (Eigen::Index i = 0; i < size; ++i) {
    if (!absorbing[static_cast<std::size_t>(i)]) result.transient.push_back(static_cast<int>(i));
  }
  const auto count = static_cast<Eigen::Index>(result.transient.size());
  // States that can end, by walking back from the ends.
  std::vector<bool> ends = absorbing;
  for (Eigen::Index round = 0; round < size; ++round) {
    for (Eigen::Index i = 0; i < size; ++i) {
      for (Eigen::Index j = 0; j < size; ++j) {
        if (probability(i, j) > 0.0 && ends[static_cast<std::size_t>(j)])
          ends[static_cast<std::size_t>(i)] = true;
      }
    }
  }
  const auto stuck = std::ranges::find(ends, false);
  if (stuck != ends.end())
    throw ArgumentError(fmt::format("from state {} no end is ever reached", stuck - ends.begin()));
  Eigen::MatrixXd gap(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      gap(i, j) = (i == j ? 1.0 : 0.0) - probability(result.transient[static_cast<std::size_t>(i)],
                                                     result.transient[static_cast<std::size_t>(j)]);
    }
  }
  result.fundamental = gap.inverse();
  result.times = result.fundamental.rowwise().sum();
  return result;
}

}  // namespace samara::motion
