#include "samara/identification/solve/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "samara/identification/problem/box_bounds.h"
#include "samara/identification/solve/motion_terms.h"
#include "samara/identification/statistics/cluster_errors.h"
#include "samara/identification/statistics/determined_inverse.h"

namespace samara::identification {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Sums over all motions, and the priors.
struct Totals {
  Eigen::MatrixXd normal, hessian;  ///< without priors of shared unknowns
  Eigen::MatrixXd own_priors;       ///< of the normal matrix, what was known of own unknowns, over mean_dpsi
  Eigen::MatrixXd priors;           ///< what those of shared ones add to the Hessian
  Eigen::VectorXd diagonal_before;
  Eigen::MatrixXd cluster_scores;                                  ///< shared x clusters
  std::vector<Eigen::MatrixXd> cluster_normals, cluster_hessians;  ///< parts of the sums
  bool hessian_usable = true;
  double psi_squares = 0.0, spread = 0.0;
  double mean_dpsi = 0.0;
  double own_unknowns = 0.0;  ///< that the data determine

  /// The Hessian with the priors, and what stands in for it: mean(psi') J^T J, in units of mean(psi').
  Eigen::MatrixXd full_hessian() const { return hessian + priors; }
  Eigen::MatrixXd full_normal() const { return normal + priors / std::max(mean_dpsi, kLeastSlope); }
};

Totals add_up(const FitProblem& problem, const std::vector<MotionTerms>& terms, const FitPoint& point,
              double slope) {
  Totals sum;
  const Eigen::Index shared_count = problem.shared_count();
  sum.normal.setZero(shared_count, shared_count);
  sum.own_priors = sum.normal;
  sum.hessian = sum.normal;
  sum.diagonal_before.setZero(shared_count);
  sum.cluster_scores.setZero(shared_count, problem.cluster_count);
  sum.cluster_normals.assign(static_cast<std::size_t>(problem.cluster_count), sum.normal);
  sum.cluster_hessians = sum.cluster_normals;
  for (std::size_t c = 0; c < terms.size(); ++c) {
    sum.normal += terms[c].normal;
    sum.own_priors += terms[c].prior_part;
    sum.hessian += terms[c].hessian;
    sum.diagonal_before += terms[c].shared_diagonal_before;
    sum.cluster_scores.col(problem.motions[c].cluster) += terms[c].score;
    const auto cluster = static_cast<std::size_t>(problem.motions[c].cluster);
    sum.cluster_normals[cluster] += terms[c].normal;
    sum.cluster_hessians[cluster] += terms[c].hessian;
    sum.hessian_usable = sum.hessian_usable && terms[c].hessian_usable;
    sum.psi_squares += terms[c].psi_squares;
    sum.spread += spread(problem, problem.motions[c]);
    sum.own_unknowns += terms[c].own_unknowns;
  }
  sum.priors = prior_terms(problem, point).information;
  sum.mean_dpsi = slope;
  return sum;
}

/// Variance of a residual as Huber's formula has it: var(psi)/mean(psi')^2. NaN if nothing is left over.
double naive_variance(const FitProblem& problem, const Totals& sum, double unknowns) {
  const int count = problem.observation_count();
  if (count <= unknowns || sum.mean_dpsi <= kLeastSlope) return kNaN;
  return sum.psi_squares / (count - unknowns) / (sum.mean_dpsi * sum.mean_dpsi);
}

/// Huber's covariance of the free unknowns. What frames say varies as their residuals do; what was known
/// beforehand, by its own deviation: with the weight m = mean(psi') of frames and K = (J^T J + P/m)^-1,
///
///     K (variance J^T J + P/m^2) K,
///
/// where P has a part of what was known of own unknowns, too, eliminated with them.
Eigen::MatrixXd naive_covariance(const Totals& sum, const std::vector<int>& free, const Eigen::MatrixXd& K,
                                 double variance) {
  const double m = std::max(sum.mean_dpsi, kLeastSlope);
  const Eigen::MatrixXd priors = sum.priors(free, free) / m + sum.own_priors(free, free);
  return variance * K + (1.0 / m - variance) * (K * priors * K);
}

/// Of the free directions of a motion: with the shared unknowns known, and what their errors bring along.
Eigen::MatrixXd own_covariance(const MotionTerms& terms, const Eigen::MatrixXd& shared, double variance,
                               double slope) {
  const Eigen::MatrixXd& K = terms.own_inverse.inverse;
  return variance * K + (1.0 / std::max(slope, kLeastSlope) - variance) * K * terms.own_priors * K +
         terms.projection * shared * terms.projection.transpose();
}

/// Of one segment, the `number`th of its motion.
/// @param covariance of the free directions of the motion
OwnUncertainty own_uncertainty(const FitProblem& problem, const MotionTerms& terms,
                               const Eigen::MatrixXd& covariance, std::size_t number,
                               const Eigen::VectorXd& own, std::vector<char> at_bound) {
  OwnUncertainty result;
  const int directions = problem.own_chart.directions();
  const int first = directions * static_cast<int>(number);
  std::vector<int> here, place;  // free directions of this segment: among all free ones, and its own
  std::vector<char> determined(static_cast<std::size_t>(directions), 1);
  for (std::size_t k = 0; k < terms.own_free.size(); ++k) {
    const int direction = terms.own_free[k] - first;
    if (direction < 0 || direction >= directions) continue;
    here.push_back(static_cast<int>(k));
    place.push_back(direction);
    determined[static_cast<std::size_t>(direction)] = terms.own_inverse.determined[k];
  }
  const Eigen::MatrixXd moves = problem.own_chart.plus_jacobian(own.data())(Eigen::all, place);
  const Eigen::VectorXd variance = (moves * covariance(here, here) * moves.transpose()).diagonal();
  const Eigen::MatrixXd all = problem.own_chart.plus_jacobian(own.data());
  result.at_bound = std::move(at_bound);
  result.standard_error.setConstant(own.size(), kNaN);
  result.determined.assign(static_cast<std::size_t>(own.size()), 1);
  for (Eigen::Index k = 0; k < own.size(); ++k) {
    const auto at = static_cast<std::size_t>(k);
    for (int d = 0; d < directions; ++d) {
      if (all(k, d) != 0.0 && !determined[static_cast<std::size_t>(d)]) result.determined[at] = 0;
    }
    if (result.determined[at] && !result.at_bound[at]) result.standard_error[k] = std::sqrt(variance[k]);
  }
  return result;
}

/// `part` at the places `indices` of a matrix of size n that is zero elsewhere.
Eigen::MatrixXd scattered(const Eigen::MatrixXd& part, const std::vector<int>& indices, Eigen::Index n) {
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(n, n);
  whole(indices, indices) = part;
  return whole;
}

/// What cluster_errors() asks for; no clusters where there are no errors.
struct ClusterParts {
  std::vector<ClusterTerms> terms;
  Eigen::MatrixXd priors;
};

/// Of the free unknowns. Where the Hessian of the loss does not serve, mean(psi') J^T J stands in, and `replaced`
/// says so.
ClusterParts cluster_parts(const FitProblem& problem, const Totals& sum, const std::vector<int>& free,
                           bool all_determined, bool& replaced) {
  if (free.empty()) return {};
  const Eigen::LLT<Eigen::MatrixXd> hessian(sum.full_hessian()(free, free).eval());
  replaced = !sum.hessian_usable || hessian.info() != Eigen::Success;
  if (problem.cluster_count < 2) return {};
  const bool with_normal = replaced || !all_determined;
  if (with_normal && sum.mean_dpsi <= kLeastSlope) return {};
  ClusterParts clusters{.terms = {}, .priors = sum.priors(free, free)};
  for (std::size_t c = 0; c < sum.cluster_hessians.size(); ++c) {
    const Eigen::MatrixXd terms =
        with_normal ? Eigen::MatrixXd(sum.mean_dpsi * sum.cluster_normals[c]) : sum.cluster_hessians[c];
    clusters.terms.push_back({terms(free, free), sum.cluster_scores.col(static_cast<Eigen::Index>(c))(free)});
  }
  // What is not determined has no error; here it must only not be in the way of the rest.
  constexpr double kRidge = 1e-10;
  Eigen::MatrixXd& priors = clusters.priors;
  if (!all_determined)
    priors.diagonal() += kRidge * (sum.mean_dpsi * sum.diagonal_before(free) + priors.diagonal());
  return clusters;
}

/// The clustered errors of the free unknowns.
ClusterErrors clustered_errors(const FitProblem& problem, const Totals& sum, const std::vector<int>& free,
                               bool all_determined, bool& replaced) {
  const auto count = static_cast<Eigen::Index>(free.size());
  const ClusterParts clusters = cluster_parts(problem, sum, free, all_determined, replaced);
  if (!clusters.terms.empty()) return cluster_errors(clusters.terms, clusters.priors);
  return {.covariance = Eigen::MatrixXd::Constant(count, count, kNaN),
          .shares = Eigen::MatrixXd::Zero(count, problem.cluster_count)};
}

/// Released variances and clusters. Of an unknown at a bound scores do not sum to nothing: they are taken at the
/// minimum beyond it, to first order.
void add_released(const FitProblem& problem, const Totals& sum, const FitPoint& point,
                  const Eigen::VectorXd& floor, Uncertainty& result) {
  const Eigen::VectorXd gradient = sum.cluster_scores.rowwise().sum() + prior_terms(problem, point).gradient;
  for (std::size_t k = 0; k < result.at_bound.size(); ++k) {
    if (!result.at_bound[k] || !result.determined[k]) continue;
    std::vector<char> held = result.at_bound;
    held[k] = 0;
    const std::vector<int> free = free_indices(held);
    const DeterminedInverse inverse = invert_determined(sum.full_normal()(free, free), floor(free));
    const auto at = std::ranges::find(free, static_cast<int>(k)) - free.begin();
    bool replaced = false;
    ClusterParts clusters = cluster_parts(problem, sum, free, inverse.all_determined(), replaced);
    if (clusters.terms.empty() || !inverse.determined[static_cast<std::size_t>(at)]) continue;
    Eigen::MatrixXd hessian = clusters.priors;
    for (const ClusterTerms& cluster : clusters.terms) hessian += cluster.hessian;
    const Eigen::VectorXd step = hessian.llt().solve(gradient(free));
    for (ClusterTerms& cluster : clusters.terms) cluster.score -= cluster.hessian * step;
    const ClusterErrors errors = cluster_errors(clusters.terms, clusters.priors);
    const auto place = static_cast<Eigen::Index>(k);
    result.released_variance[place] = errors.covariance(at, at);
    result.released_clusters[place] = effective_clusters(errors.shares.row(at).transpose());
  }
}

/// Whether so few residuals lie within the bend that their number says little, frames taken as independent.
bool is_slope_rough(const FitProblem& problem, const std::vector<SegmentResidual>& residuals, double slope) {
  constexpr double kRough = 0.25;
  double squares = 0.0;
  for (const SegmentResidual& residual : residuals) {
    for (int row = 0; row < residual.data_size(); ++row)
      squares += std::pow(loss_value(problem.loss, residual.residual()[row]).dpsi - slope, 2);
  }
  return slope <= kLeastSlope || std::sqrt(squares) > kRough * slope * problem.observation_count();
}

/// The Hessian of the cost where it is one of a minimum, else what stands in for it.
Eigen::MatrixXd information_of(const Totals& sum) {
  const Eigen::MatrixXd hessian = sum.full_hessian();
  const Eigen::LLT<Eigen::MatrixXd> factor(hessian);
  if (sum.hessian_usable && factor.info() == Eigen::Success) return hessian;
  return sum.mean_dpsi > kLeastSlope ? Eigen::MatrixXd(sum.mean_dpsi * sum.full_normal()) : sum.normal;
}

/// NaN in the rows and columns of unknowns that have no errors.
void hide(const std::vector<char>& has_error, Eigen::MatrixXd& matrix) {
  for (std::size_t k = 0; k < has_error.size(); ++k) {
    if (has_error[k]) continue;
    matrix.row(static_cast<Eigen::Index>(k)).setConstant(kNaN);
    matrix.col(static_cast<Eigen::Index>(k)).setConstant(kNaN);
  }
}

}  // namespace

Uncertainty estimate_uncertainty(const FitProblem& problem, std::vector<SegmentResidual>& residuals,
                                 const FitPoint& point, bool with_released) {
  Uncertainty result;
  evaluate_all(residuals, point);
  const double slope = mean_slope(problem, residuals);
  std::vector<MotionTerms> terms;
  for (const Motion& motion : problem.motions) {
    terms.push_back(
        motion_terms(problem, motion, residuals, point, slope, free_directions(problem, motion, point)));
  }
  const Totals sum = add_up(problem, terms, point, slope);

  // Those at a bound are asked too: an unknown without influence may have drifted there. What is left of one
  // beside the own unknowns must also stand out of rounding.
  const Eigen::VectorXd floor =
      influence_floor(problem.shared, free_indices(std::vector<char>(problem.shared.size(), 0)), sum.spread)
          .cwiseMax(kNoInfluence * sum.diagonal_before);
  const Eigen::MatrixXd normal = sum.full_normal();
  const DeterminedInverse whole = invert_determined(normal, floor);
  result.determined = whole.determined;
  result.undetermined_sets = whole.undetermined_sets;
  const bool are_of_one =
      std::ranges::all_of(problem.priors, [](const PriorTerm& prior) { return prior.weights().size() == 1; });
  if (whole.all_determined() && !problem.priors.empty() && are_of_one) {
    result.sets_held_by_priors = invert_determined(sum.normal, floor).undetermined_sets;
  }
  result.at_bound = at_bounds(problem.shared, problem.shared_chart, point.shared);

  const std::vector<int> free = free_indices(result.at_bound);
  const Eigen::Index all = problem.shared_count();
  const DeterminedInverse inverse = invert_determined(normal(free, free), floor(free));
  const Eigen::MatrixXd measured = (sum.normal - sum.own_priors)(free, free);
  const double unknowns = (inverse.inverse * measured).trace() + sum.own_unknowns;
  const double variance = naive_variance(problem, sum, unknowns);
  result.information = information_of(sum);
  result.dispersion = variance * sum.mean_dpsi;
  result.residual_freedom = problem.observation_count() - static_cast<int>(std::lround(unknowns));
  // Errors count that own unknowns at bounds may be elsewhere.
  std::vector<MotionTerms> released;
  for (std::size_t c = 0; c < terms.size(); ++c) {
    const BoundedDirections own = bounded_directions(problem, problem.motions[c], point);
    released.push_back(
        own.any ? motion_terms(problem, problem.motions[c], residuals, point, slope, own.all, own.information)
                : terms[c]);
  }
  const Totals loose = add_up(problem, released, point, slope);
  const DeterminedInverse loose_inverse = invert_determined(loose.full_normal()(free, free), floor(free));
  result.naive = scattered(naive_covariance(loose, free, loose_inverse.inverse, variance), free, all);
  bool hessian_replaced = false;
  const ClusterErrors clustered =
      clustered_errors(problem, loose, free, loose_inverse.all_determined(), hessian_replaced);
  result.clustered = scattered(clustered.covariance, free, all);
  result.cluster_shares = Eigen::MatrixXd::Zero(all, problem.cluster_count);
  result.cluster_shares(free, Eigen::all) = clustered.shares;
  result.released_variance.setConstant(all, kNaN);
  result.released_clusters = result.released_variance;
  if (with_released) add_released(problem, loose, point, floor, result);
  for (std::size_t c = 0; c < terms.size(); ++c) {
    const Eigen::MatrixXd covariance = own_covariance(terms[c], result.naive, variance, slope);
    for (std::size_t k = 0; k < problem.motions[c].segment_count; ++k) {
      const Eigen::VectorXd& own = point.own[problem.motions[c].first_segment + k];
      result.own.push_back(
          own_uncertainty(problem, terms[c], covariance, k, own, own_at_bounds(problem, own)));
    }
  }

  // A Hessian that is singular because something is not determined says nothing of the loss.
  const bool all_determined =
      whole.all_determined() &&
      std::ranges::all_of(terms, [](const MotionTerms& own) { return own.own_inverse.all_determined(); });
  result.beyond_bend = problem.loss != LossKind::none &&
                       ((hessian_replaced && all_determined) || is_slope_rough(problem, residuals, slope));

  std::vector<char> has_error = result.determined;
  for (std::size_t k = 0; k < has_error.size(); ++k) has_error[k] = has_error[k] && !result.at_bound[k];
  hide(has_error, result.naive);
  hide(has_error, result.clustered);
  return result;
}

}  // namespace samara::identification
