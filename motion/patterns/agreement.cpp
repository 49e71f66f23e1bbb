#include "samara/motion/patterns/agreement.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::motion {

namespace {

void check_labels(const std::vector<int>& first, const std::vector<int>& second) {
  if (first.size() != second.size() || first.empty()) {
    throw ArgumentError(fmt::format("there are {} labels beside {}, expected as many, and some",
                                    second.size(), first.size()));
  }
  for (const auto* labels : {&first, &second}) {
    const int least = *std::ranges::min_element(*labels);
    if (least < 0) throw ArgumentError(fmt::format("a label is {}, expected 0 or more", least));
  }
}

Eigen::MatrixXi counts_of(const std::vector<int>& first, const std::vector<int>& second, int rows,
                          int columns) {
  Eigen::MatrixXi counts = Eigen::MatrixXi::Zero(rows, columns);
  for (std::size_t k = 0; k < first.size(); ++k) ++counts(first[k], second[k]);
  return counts;
}

/// Pairs within each entry.
double pairs_within(const Eigen::ArrayXXi& counts) {
  const Eigen::ArrayXXd n = counts.cast<double>();
  return (0.5 * n * (n - 1.0)).sum();
}

double adjusted_rand_of(const Eigen::MatrixXi& counts) {
  const double n = counts.sum();
  const double all = 0.5 * n * (n - 1.0);
  const double rows = pairs_within(counts.rowwise().sum().array());
  const double columns = pairs_within(counts.colwise().sum().array());
  const double expected = all > 0.0 ? rows * columns / all : 0.0;
  const double most = 0.5 * (rows + columns);
  // Both put all into one class, or each thing into its own: the partitions are the same.
  if (most == expected) return 1.0;
  return (pairs_within(counts.array()) - expected) / (most - expected);
}

}  // namespace

double adjusted_rand(const std::vector<int>& first, const std::vector<int>& second) {
  check_labels(first, second);
  return adjusted_rand_of(
      counts_of(first, second, *std::ranges::max_element(first) + 1, *std::ranges::max_element(second) + 1));
}

Agreement agreement(const std::vector<int>& truth, const std::vector<int>& answer, int classes) {
  check_labels(truth, answer);
  const int most = std::max(*std::ranges::max_element(truth), *std::ranges::max_element(answer));
  if (most >= classes)
    throw ArgumentError(fmt::format("a label is {}, expected less than {}", most, classes));
  Agreement result;
  result.confusion = counts_of(truth, answer, classes, classes);
  const Eigen::MatrixXd counts = result.confusion.cast<double>();
  const double n = counts.sum();
  result.share = counts.trace() / n;
  const Eigen::VectorXd rows = counts.rowwise().sum();
  int seen = 0;
  for (int c = 0; c < classes; ++c) {
    if (rows[c] == 0.0) continue;
    result.balanced += counts(c, c) / rows[c];
    ++seen;
  }
  result.balanced /= seen;
  const double chance = rows.dot(counts.colwise().sum().transpose()) / (n * n);
  result.kappa = chance < 1.0 ? (result.share - chance) / (1.0 - chance) : 1.0;
  result.adjusted_rand = adjusted_rand_of(result.confusion);
  return result;
}

}  // namespace samara::motion
