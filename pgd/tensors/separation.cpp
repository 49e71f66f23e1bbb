#include "samara/pgd/tensors/separation.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/require.h"
#include "samara/pgd/tensors/sum_fit.h"
#include "samara/pgd/tensors/train_algebra.h"

namespace samara::pgd {

namespace {

/// One product so far: the ranks chosen from the left, and the norm of the product of their cores.
struct Beginning {
  std::vector<int> ranks;
  double norm = 0.0;
};

/// Norms of the columns of every core: entry (l, r) of core k.
std::vector<Eigen::MatrixXd> link_norms(const TensorTrain& train) {
  std::vector<Eigen::MatrixXd> norms;
  for (const TrainCore& core : train.cores) {
    Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(core.left, core.right);
    for (int i = 0; i < core.size; ++i) squares += core.slice(i).cwiseAbs2();
    norms.emplace_back(squares.cwiseSqrt());
  }
  return norms;
}

/// Beginnings one mode longer.
std::vector<Beginning> lengthened(const std::vector<Beginning>& beginnings, const Eigen::MatrixXd& links) {
  std::vector<Beginning> longer;
  for (const Beginning& beginning : beginnings) {
    const int left = beginning.ranks.empty() ? 0 : beginning.ranks.back();
    for (Eigen::Index r = 0; r < links.cols(); ++r) {
      Beginning next = beginning;
      next.ranks.push_back(static_cast<int>(r));
      next.norm *= links(left, r);
      if (next.norm > 0.0) longer.push_back(std::move(next));
    }
  }
  return longer;
}

/// Drops the smallest beginnings as long as their norms sum to at most `allowed`; subtracts what was spent.
void prune(std::vector<Beginning>& beginnings, double& allowed) {
  std::sort(beginnings.begin(), beginnings.end(),
            [](const Beginning& a, const Beginning& b) { return a.norm > b.norm; });
  while (!beginnings.empty() && beginnings.back().norm <= allowed) {
    allowed -= beginnings.back().norm;
    beginnings.pop_back();
  }
}

SeparatedTensor products(const TensorTrain& train, const std::vector<Beginning>& chains) {
  SeparatedTensor sum;
  const auto count = static_cast<Eigen::Index>(chains.size());
  sum.weights = Eigen::VectorXd::Ones(count);
  for (std::size_t k = 0; k < train.cores.size(); ++k) {
    const TrainCore& core = train.cores[k];
    Eigen::MatrixXd factor(core.size, count);
    for (Eigen::Index c = 0; c < count; ++c) {
      const std::vector<int>& ranks = chains[static_cast<std::size_t>(c)].ranks;
      const Eigen::Index left = k == 0 ? 0 : ranks[k - 1];
      for (int i = 0; i < core.size; ++i) {
        factor(i, c) = core.data[left + Eigen::Index{core.left} * (i + Eigen::Index{core.size} * ranks[k])];
      }
    }
    sum.factors.push_back(std::move(factor));
  }
  sum.normalise();
  return sum;
}

struct Expansion {
  SeparatedTensor sum;
  double dropped = 0.0;  ///< norms of the beginnings left out, which bounds the error
};

/// The expansion within `tolerance`, or nothing if it has more than `max_terms` products. The cores after
/// the first must be orthonormal from the right, as rounded() leaves them: the sum over all continuations of
/// a beginning then has exactly the norm of the beginning.
std::optional<Expansion> expansion(const TensorTrain& train, double tolerance, int max_terms) {
  const double budget = tolerance;
  const std::vector<Eigen::MatrixXd> links = link_norms(train);
  std::vector<Beginning> chains = {{{}, 1.0}};
  for (const Eigen::MatrixXd& link : links) {
    chains = lengthened(chains, link);
    // Each mode may spend half of what is left, the last one all of it.
    double allowed = &link == &links.back() ? tolerance : 0.5 * tolerance;
    const double before = allowed;
    prune(chains, allowed);
    tolerance -= before - allowed;
    if (static_cast<int>(chains.size()) > max_terms) return std::nullopt;
  }
  return Expansion{products(train, chains), budget - tolerance};
}

/// Largest rank of an unfolding at this tolerance: no sum within it has fewer terms.
int least_rank(const TensorTrain& train, double tolerance) {
  const double per_cut = tolerance * std::sqrt(std::max(1.0, train.modes() - 1.0));
  int rank = 1;
  for (const int r : rounded(train, per_cut).ranks()) rank = std::max(rank, r);
  return rank;
}

/// The shorter one of the expansion and a fit.
void look_for_sum(const TensorTrain& train, double tolerance, int max_terms, Separation& result) {
  // A share for rounding, the rest for the sum.
  const TensorTrain cut = rounded(train, 0.2 * tolerance);
  result.chains = 1.0;
  for (const int rank : cut.ranks()) result.chains *= rank;
  // A sum within the tolerance of the train is within both of what was cut from it.
  const int least = least_rank(cut, 1.2 * tolerance);
  std::optional<Expansion> expanded = expansion(cut, 0.8 * tolerance, max_terms);
  const int shorter = expanded ? expanded->sum.rank() - 1 : max_terms;
  if (!expanded || least <= shorter) {
    SumFit fit = fit_sum(cut, {0.8 * tolerance, least, std::min(shorter, kMaxFittedTerms)});
    if (fit.met || !expanded) {
      result.tensor = std::move(fit.tensor);
      result.error = distance(to_train(result.tensor), train);
      return;
    }
  }
  result.tensor = std::move(expanded->sum);
  result.expanded = true;
  result.error = distance(cut, train) + expanded->dropped;
}

void report(Separation& result, double tolerance, int max_terms) {
  const bool met = result.error <= tolerance && result.tensor.rank() <= max_terms;
  result.status = met ? Termination::converged : Termination::rank_limit;
  result.message =
      fmt::format("error {:.3g} {} {:.3g} with {} terms ({} allowed), {:.3g} products in the full expansion",
                  result.error, result.error <= tolerance ? "<=" : ">", tolerance, result.tensor.rank(),
                  max_terms, result.chains);
}

}  // namespace

Separation separate(const TensorTrain& train, double tolerance, int max_terms) {
  require(!train.cores.empty(), "the number of modes", train.modes(), "at least 1", "separate");
  require(tolerance >= 0.0, "tolerance", tolerance, "at least 0", "separate");
  require(max_terms >= 0, "max_terms", max_terms, "at least 0", "separate");
  Separation result;
  for (const TrainCore& core : train.cores) result.tensor.factors.emplace_back(core.size, 0);
  result.error = norm(train);
  if (result.error > tolerance) look_for_sum(train, tolerance, max_terms, result);
  report(result, tolerance, max_terms);
  return result;
}

}  // namespace samara::pgd
