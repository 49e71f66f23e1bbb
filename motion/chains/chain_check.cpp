#include "samara/motion/chains/chain_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/statistics/quantiles.h"

namespace samara::motion {

namespace {

constexpr Eigen::Index kLengths = 5;  // 1, 2, 3, 4, and more

/// Of lengths that were seen against those that are expected.
struct ChiSquare {
  double value = 0.0;
  int freedom = 0;  ///< 0: all lengths had to be taken together
};

/// Neighbouring lengths are taken together until five runs or more are expected of each: fewer do not scatter as
/// chi-square has it.
ChiSquare chi_square_of(const Eigen::VectorXd& seen, const Eigen::VectorXd& expected) {
  constexpr double kFewestExpected = 5.0;
  std::vector<Eigen::Vector2d> classes;  // seen, expected
  Eigen::Vector2d open = Eigen::Vector2d::Zero();
  for (Eigen::Index k = 0; k < seen.size(); ++k) {
    open += Eigen::Vector2d(seen[k], expected[k]);
    if (open[1] < kFewestExpected) continue;
    classes.push_back(open);
    open.setZero();
  }
  if (classes.size() < 2) return {};
  classes.back() += open;
  ChiSquare result = {.freedom = static_cast<int>(classes.size()) - 1};
  for (const Eigen::Vector2d& one : classes) result.value += (one[0] - one[1]) * (one[0] - one[1]) / one[1];
  return result;
}

/// What the largest of independent chi-squares stays below in this share of cases. NaN if none has a freedom.
double largest_quantile(const Eigen::VectorXi& freedom, double share) {
  const auto below = [&](double value) {
    double chance = 1.0;
    for (const int one : freedom) {
      if (one > 0) chance *= 1.0 - identification::chi_squared_tail(one, value);
    }
    return chance;
  };
  if (freedom.maxCoeff() < 1) return std::numeric_limits<double>::quiet_NaN();
  double low = 0.0, high = 1.0;
  while (below(high) < share) high *= 2.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (below(middle) < share ? low : high) = middle;
  }
  return high;
}

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
  drawn.reserve(kTimes * sequences.size());
  for (std::size_t n = 0; n < sequences.size(); ++n) {
    Stream stream(seed, n);
    // As long as those seen: a sequence cuts long runs more often than short ones.
    for (int k = 0; k < kTimes; ++k) drawn.push_back(chain.draw_sequence(sequences[n].size(), stream));
  }
  result.chi_square.setConstant(chain.symbols(), std::numeric_limits<double>::quiet_NaN());
  result.freedom.setZero(chain.symbols());
  for (int symbol = 0; symbol < chain.symbols(); ++symbol) {
    const Eigen::VectorXd seen = run_lengths(sequences, symbol), own = run_lengths(drawn, symbol);
    if (seen.sum() < 25.0 || own.sum() == 0.0) continue;
    const ChiSquare found = chi_square_of(seen, own * (seen.sum() / own.sum()));
    if (found.freedom == 0) continue;
    result.chi_square[symbol] = found.value;
    result.freedom[symbol] = found.freedom;
  }
  result.largest_95 = largest_quantile(result.freedom, 0.95);
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
