#include "samara/motion/patterns/transitions.h"

#include <algorithm>
#include <limits>

#include "samara/motion/chains/markov_chain.h"

namespace samara::motion {

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
  all.lower = all.upper = all.probability;
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
  return all;
}

}  // namespace samara::motion
