#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/streams.h"

/// Markov chains of any order over a few symbols (kinds of events, patterns), from sequences that were seen.
///
///   const OrderChoice choice = select_order(sequences, 4);
///   const MarkovChain chain = MarkovChain::fitted(sequences, 4, choice.order);
///   const int next = chain.draw(past, stream);              // no allocation
///
/// p(next | context) = (N(context, next) + 1/2)/(N(context) + s/2) for s symbols (Dirichlet prior of 1/2): what was
/// not seen may still happen. A context that was seen fewer than 5 times gives way to the one shorter by its oldest
/// symbol. A chain that reproduces how often each symbol comes has shown nothing: every chain made of counts does.
/// What counts are the held-out likelihood, the lengths of runs, and steps taken two at a time (chain_check.h).
namespace samara::motion {

/// An estimate from counts, with the 2.5 and 97.5 % points of its beta marginal.
struct Chance {
  double probability = 0.0, lower = 0.0, upper = 0.0;
};

/// (count + 1/2)/(total + kinds/2). @param kinds that could have come
Chance dirichlet_chance(double count, double total, double kinds);

class MarkovChain {
 public:
  static constexpr int kFewest = 5;  ///< counts of a context that is used
  static constexpr int kMostOrder = 8;

  /// @param sequences of symbols from 0 to symbols - 1, each of one run: nothing follows across their ends
  /// @throws ArgumentError for other symbols, an order below 0 or above kMostOrder, or more than 10^7 counts.
  static MarkovChain fitted(const std::vector<std::vector<int>>& sequences, int symbols, int order);

  /// Of the first order, from counts (from, to). @throws ArgumentError unless square, not negative and finite.
  static MarkovChain of_counts(const Eigen::Ref<const Eigen::MatrixXd>& counts);

  int symbols() const { return symbols_; }
  int order() const { return order_; }

  /// @param past symbols, the latest last; of more than the order the last ones are taken
  double probability(std::span<const int> past, int next) const;
  Chance chance(std::span<const int> past, int next) const;
  int draw(std::span<const int> past, Stream& stream) const;
  /// Among the symbols that are not left out, one at least.
  /// @param left_out per symbol
  int draw(std::span<const int> past, std::span<const char> left_out, Stream& stream) const;

  /// A sequence that begins as often with each symbol as it was seen.
  std::vector<int> draw_sequence(std::size_t length, Stream& stream) const;

  /// Of the first order: rows from, columns to. @throws ArgumentError for another order.
  Eigen::MatrixXd matrix() const;

  /// Counts of the longest contexts: symbols^order rows, the latest symbol of a context running fastest.
  Eigen::MatrixXd counts() const;

  /// Mean log-likelihood of the symbols from number `from` of each sequence on. NaN if there are none.
  double log_likelihood(const std::vector<std::vector<int>>& sequences, std::size_t from) const;

 private:
  MarkovChain(int symbols, int order);
  /// Where the counts of a context begin, shortened as far as needed.
  const double* counts_after(std::span<const int> past, double& total) const;

  int symbols_ = 0, order_ = 0;
  std::vector<std::vector<double>> counts_;  // per length of context
};

struct OrderScore {
  int order = 0;
  double log_likelihood = 0.0;  ///< per symbol, of runs left out
  double error = 0.0;           ///< standard error over runs of its distance to the best
};

struct OrderChoice {
  int order = 0;  ///< the smallest within one standard error of the best
  std::vector<OrderScore> scores;
  std::size_t fitted_runs = 0, held_out_runs = 0;
};

/// Half of the runs of more than `most` symbols, which are drawn, to fit chains to, and the others. The same runs
/// give the same halves.
struct RunHalves {
  std::vector<std::vector<int>> fit, held_out;
};
RunHalves halves_of(const std::vector<std::vector<int>>& sequences, int most);

/// By the log-likelihood of one of the halves under chains of the other.
/// @throws ArgumentError as fitted(), or for fewer than two runs that are longer than `most`.
OrderChoice select_order(const std::vector<std::vector<int>>& sequences, int symbols, int most = 5);

/// The chain of patterns of the dissertation, (5.25): smallest counts that give its printed digits. A zero there is
/// an event that was not seen in a few dozen, not one that cannot happen.
struct SourceChain {
  std::vector<std::string> names;     ///< SD, AR, AZ, ZZ
  std::vector<std::string> patterns;  ///< what these are called here
  Eigen::MatrixXd counts;             ///< from, to; none from ZZ, in which it ends
  Eigen::MatrixXd printed;            ///< probabilities, three digits
};
SourceChain source_chain();

}  // namespace samara::motion
