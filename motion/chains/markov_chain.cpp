#include "samara/motion/chains/markov_chain.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/statistics/quantiles.h"

namespace samara::motion {

namespace {

void check_symbols(const std::vector<std::vector<int>>& sequences, int symbols) {
  for (const std::vector<int>& sequence : sequences) {
    for (const int symbol : sequence) {
      if (symbol < 0 || symbol >= symbols)
        throw ArgumentError(
            fmt::format("a sequence has the symbol {}, expected one from 0 to {}", symbol, symbols - 1));
    }
  }
}

/// Sum and number of log-likelihoods of a sequence.
struct LogSum {
  double sum = 0.0;
  double count = 0.0;
};

LogSum log_sum(const MarkovChain& chain, const std::vector<int>& sequence, std::size_t from) {
  LogSum all;
  for (std::size_t k = from; k < sequence.size(); ++k) {
    all.sum += std::log(chain.probability(std::span(sequence).first(k), sequence[k]));
    all.count += 1.0;
  }
  return all;
}

}  // namespace

Chance dirichlet_chance(double count, double total, double kinds) {
  const double a = count + 0.5, b = total - count + 0.5 * (kinds - 1.0);
  // Where nothing else could have come.
  if (!(b > 0.0)) return {1.0, 1.0, 1.0};
  return {a / (a + b), identification::beta_quantile(a, b, 0.025),
          identification::beta_quantile(a, b, 0.975)};
}

MarkovChain::MarkovChain(int symbols, int order) : symbols_(symbols), order_(order) {
  if (symbols < 1)
    throw ArgumentError(fmt::format("a chain of {} symbols was asked for, expected 1 or more", symbols));
  if (order < 0 || order > kMostOrder)
    throw ArgumentError(fmt::format("the order of the chain is {}, expected 0 to {}", order, kMostOrder));
  if (std::pow(symbols, order + 1) > 1e7)
    throw ArgumentError(
        fmt::format("a chain of order {} over {} symbols has more than 10^7 counts", order, symbols));
  std::size_t size = static_cast<std::size_t>(symbols);
  for (int length = 0; length <= order; ++length) {
    counts_.emplace_back(size, 0.0);
    size *= static_cast<std::size_t>(symbols);
  }
}

MarkovChain MarkovChain::fitted(const std::vector<std::vector<int>>& sequences, int symbols, int order) {
  MarkovChain chain(symbols, order);
  check_symbols(sequences, symbols);
  const auto s = static_cast<std::size_t>(symbols);
  for (const std::vector<int>& sequence : sequences) {
    for (std::size_t k = 0; k < sequence.size(); ++k) {
      std::size_t context = 0, scale = 1;
      for (std::size_t length = 0; length <= std::min(k, static_cast<std::size_t>(order)); ++length) {
        if (length > 0) {
          context += scale * static_cast<std::size_t>(sequence[k - length]);
          scale *= s;
        }
        chain.counts_[length][context * s + static_cast<std::size_t>(sequence[k])] += 1.0;
      }
    }
  }
  return chain;
}

MarkovChain MarkovChain::of_counts(const Eigen::Ref<const Eigen::MatrixXd>& counts) {
  if (counts.rows() != counts.cols() || counts.rows() == 0 || !counts.allFinite() || counts.minCoeff() < 0.0)
    throw ArgumentError("the counts of a chain are not a square of finite numbers from 0 on");
  MarkovChain chain(static_cast<int>(counts.rows()), 1);
  for (Eigen::Index i = 0; i < counts.rows(); ++i) {
    for (Eigen::Index j = 0; j < counts.cols(); ++j) {
      chain.counts_[1][static_cast<std::size_t>(i * counts.cols() + j)] = counts(i, j);
      chain.counts_[0][static_cast<std::size_t>(j)] += counts(i, j);
    }
  }
  return chain;
}

const double* MarkovChain::counts_after(std::span<const int> past, double& total) const {
  const auto s = static_cast<std::size_t>(symbols_);
  for (std::size_t length = std::min(past.size(), static_cast<std::size_t>(order_));; --length) {
    std::size_t context = 0;
    for (std::size_t k = past.size() - length; k < past.size(); ++k)
      context = context * s + static_cast<std::size_t>(past[k]);
    const double* counts = counts_[length].data() + context * s;
    total = 0.0;
    for (std::size_t j = 0; j < s; ++j) total += counts[j];
    if (total >= kFewest || length == 0) return counts;
  }
}

double MarkovChain::probability(std::span<const int> past, int next) const {
  double total = 0.0;
  const double* counts = counts_after(past, total);
  return (counts[next] + 0.5) / (total + 0.5 * symbols_);
}

Chance MarkovChain::chance(std::span<const int> past, int next) const {
  double total = 0.0;
  const double* counts = counts_after(past, total);
  return dirichlet_chance(counts[next], total, symbols_);
}

int MarkovChain::draw(std::span<const int> past, Stream& stream) const {
  double total = 0.0;
  const double* counts = counts_after(past, total);
  double left = stream.uniform() * (total + 0.5 * symbols_);
  for (int next = 0; next + 1 < symbols_; ++next) {
    left -= counts[next] + 0.5;
    if (left < 0.0) return next;
  }
  return symbols_ - 1;
}

int MarkovChain::draw(std::span<const int> past, std::span<const char> left_out, Stream& stream) const {
  double total = 0.0, among = 0.0;
  const double* counts = counts_after(past, total);
  int last = 0;
  for (int next = 0; next < symbols_; ++next) {
    if (left_out[static_cast<std::size_t>(next)] != 0) continue;
    among += counts[next] + 0.5;
    last = next;
  }
  double left = stream.uniform() * among;
  for (int next = 0; next < last; ++next) {
    if (left_out[static_cast<std::size_t>(next)] != 0) continue;
    left -= counts[next] + 0.5;
    if (left < 0.0) return next;
  }
  return last;
}

std::vector<int> MarkovChain::draw_sequence(std::size_t length, Stream& stream) const {
  std::vector<int> sequence;
  sequence.reserve(length);
  while (sequence.size() < length) sequence.push_back(draw(sequence, stream));
  return sequence;
}

Eigen::MatrixXd MarkovChain::matrix() const {
  if (order_ != 1)
    throw ArgumentError(
        fmt::format("the matrix of a chain of order {} was asked for, expected order 1", order_));
  Eigen::MatrixXd p(symbols_, symbols_);
  for (int i = 0; i < symbols_; ++i) {
    for (int j = 0; j < symbols_; ++j) p(i, j) = probability({&i, 1}, j);
  }
  return p;
}

Eigen::MatrixXd MarkovChain::counts() const {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const std::vector<double>& longest = counts_.back();
  return Eigen::Map<const Rows>(longest.data(), static_cast<Eigen::Index>(longest.size()) / symbols_,
                                symbols_);
}

double MarkovChain::log_likelihood(const std::vector<std::vector<int>>& sequences, std::size_t from) const {
  check_symbols(sequences, symbols_);
  LogSum all;
  for (const std::vector<int>& sequence : sequences) {
    const LogSum one = log_sum(*this, sequence, from);
    all.sum += one.sum;
    all.count += one.count;
  }
  return all.sum / all.count;
}

RunHalves halves_of(const std::vector<std::vector<int>>& sequences, int most) {
  std::vector<std::pair<double, std::size_t>> drawn;
  const auto from = static_cast<std::size_t>(std::max(most, 0));
  for (std::size_t n = 0; n < sequences.size(); ++n) {
    if (sequences[n].size() > from) drawn.emplace_back(Stream(1, n).uniform(), n);
  }
  // By a draw: runs that stand beside each other, or two apart, may be alike, as from one release.
  std::ranges::sort(drawn);
  RunHalves halves;
  for (std::size_t k = 0; k < drawn.size(); ++k)
    (2 * k < drawn.size() ? halves.fit : halves.held_out).push_back(sequences[drawn[k].second]);
  return halves;
}

OrderChoice select_order(const std::vector<std::vector<int>>& sequences, int symbols, int most) {
  const auto [fit, held_out] = halves_of(sequences, most);
  const auto from = static_cast<std::size_t>(std::max(most, 0));
  if (held_out.empty())
    throw ArgumentError(
        fmt::format("{} run{} longer than {} events, expected two or more to select an order by", fit.size(),
                    fit.size() == 1 ? " is" : "s are", most));
  OrderChoice choice;
  choice.fitted_runs = fit.size();
  choice.held_out_runs = held_out.size();
  const auto runs = static_cast<Eigen::Index>(held_out.size());
  Eigen::MatrixXd sums(runs, most + 1);
  double count = 0.0;
  for (int order = 0; order <= most; ++order) {
    const MarkovChain chain = MarkovChain::fitted(fit, symbols, order);
    count = 0.0;
    for (Eigen::Index n = 0; n < runs; ++n) {
      const LogSum one = log_sum(chain, held_out[static_cast<std::size_t>(n)], from);
      sums(n, order) = one.sum;
      count += one.count;
    }
  }
  Eigen::Index best = 0;
  sums.colwise().sum().maxCoeff(&best);
  for (int order = 0; order <= most; ++order) {
    // The scatter of a sum over runs.
    const Eigen::VectorXd behind = sums.col(best) - sums.col(order);
    const double spread =
        runs > 1 ? (behind.array() - behind.mean()).square().sum() / static_cast<double>(runs - 1) : 0.0;
    choice.scores.push_back(
        {order, sums.col(order).sum() / count, std::sqrt(spread * static_cast<double>(runs)) / count});
  }
  const double top = choice.scores[static_cast<std::size_t>(best)].log_likelihood;
  for (const OrderScore& score : choice.scores) {
    choice.order = score.order;
    if (score.log_likelihood >= top - score.error) break;
  }
  return choice;
}

SourceChain source_chain() {
  SourceChain chain;
  chain.names = {"SD", "AR", "AZ", "ZZ"};
  chain.patterns = {"steady", "autorotation", "mixed", "zigzag"};
  chain.counts.setZero(4, 4);
  chain.counts << 4, 10, 1, 11, 0, 31, 7, 43, 0, 0, 15, 8, 0, 0, 0, 0;
  chain.printed.setZero(4, 4);
  chain.printed << 0.154, 0.385, 0.038, 0.423, 0, 0.383, 0.086, 0.531, 0, 0, 0.652, 0.348, 0, 0, 0, 1;
  return chain;
}

}  // namespace samara::motion
