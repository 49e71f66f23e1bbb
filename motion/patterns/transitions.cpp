#include "samara/motion/patterns/transitions.h"

#include <algorithm>
#include <limits>

#include "samara/motion/chains/chain_check.h"

namespace samara::motion {

namespace {

/// Of a chain that goes on until it comes to a pattern, for each of those that were seen.
void add_changes(Transitions& all, const std::vector<bool>& seen) {
  std::vector<Eigen::Index> patterns;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (seen[k]) patterns.push_back(static_cast<Eigen::Index>(k));
  }
  Eigen::MatrixXd steps = all.probability(patterns, patterns);
  steps.diagonal().setZero();
  if (!steps.allFinite()) return;
  for (std::size_t end = 0; end < patterns.size(); ++end) {
    std::vector<bool> ends(patterns.size(), false);
    ends[end] = true;
    const Absorption until = absorption(steps, ends);
    for (std::size_t k = 0; k < until.transient.size(); ++k)
      all.changes(patterns[static_cast<std::size_t>(until.transient[k])], patterns[end]) =
          until.times[static_cast<Eigen::Index>(k)];
  }
}

}  // namespace

Transitions transitions(const std::vector<std::vector<Pattern>>& sequences) {
  constexpr auto kSize = static_cast<Eigen::Index>(kPatterns);
  Transitions all;
  all.counts.setZero(kSize, kSize);
  all.falls = static_cast<int>(sequences.size());
  std::vector<bool> seen(kPatterns, false);
  for (const std::vector<Pattern>& sequence : sequences) {
    Eigen::Index before = -1;
    for (const Pattern pattern : sequence) {
      if (pattern == Pattern::unresolved) continue;
      const auto here = static_cast<Eigen::Index>(pattern);
      seen[static_cast<std::size_t>(here)] = true;
      if (before >= 0 && before != here) ++all.counts(before, here);
      before = here;
    }
  }
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  all.probability.setConstant(kSize, kSize, unknown);
  all.lower = all.upper = all.changes = all.probability;
  const auto kinds = static_cast<double>(std::count(seen.begin(), seen.end(), true));
  if (kinds < 2.0) return all;
  for (Eigen::Index i = 0; i < kSize; ++i) {
    const double total = all.counts.row(i).sum();
    if (total == 0.0) continue;
    for (Eigen::Index j = 0; j < kSize; ++j) {
      if (i == j || !seen[static_cast<std::size_t>(i)] || !seen[static_cast<std::size_t>(j)]) continue;
      // Nothing follows itself.
      const Chance share = dirichlet_chance(all.counts(i, j), total, kinds - 1.0);
      all.probability(i, j) = share.probability;
      all.lower(i, j) = share.lower;
      all.upper(i, j) = share.upper;
    }
  }
  add_changes(all, seen);
  return all;
}

}  // namespace samara::motion
