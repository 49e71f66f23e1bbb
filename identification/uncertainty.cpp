#include "samara/identification/uncertainty.h"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "samara/identification/box_bounds.h"
#include "samara/identification/determined_inverse.h"
#include "samara/identification/loss.h"

namespace samara::identification {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Influence on the residuals over the whole box, relative to the spread of the measurements, squared: below
/// it there is none.
constexpr double kNoInfluence = 1e-14;
/// Of the mean of psi': below it all residuals are outliers, and there are no errors.
constexpr double kLeastSlope = 1e-12;

std::vector<char> own_at_bounds(const FitProblem& problem, const Eigen::VectorXd& own) {
  return at_bounds(problem.own, problem.own_chart, own);
}

/// Directions of all segments of a motion whose unknowns are not at bounds.
std::vector<int> free_directions(const FitProblem& problem, const Motion& motion, const FitPoint& point) {
  std::vector<int> free;
  const int directions = problem.own_chart.directions();
  for (std::size_t k = 0; k < motion.segment_count; ++k) {
    const std::vector<char> held = own_at_bounds(problem, point.own[motion.first_segment + k]);
    for (std::size_t u = 0; u < held.size(); ++u) {
      if (held[u] || problem.own_chart.direction_of(static_cast<int>(u)) < 0) continue;
      free.push_back(directions * static_cast<int>(k) + problem.own_chart.direction_of(static_cast<int>(u)));
    }
  }
  return free;
}

/// Indices of what is not at a bound.
std::vector<int> free_indices(const std::vector<char>& at_bound) {
  std::vector<int> indices;
  for (std::size_t k = 0; k < at_bound.size(); ++k) {
    if (!at_bound[k]) indices.push_back(static_cast<int>(k));
  }
  return indices;
}

/// Sum of squares of what was measured, less the mean of each output, over the loss scales.
/// A compared attitude counts as a turn by one rad.
double spread(const FitProblem& problem, const Motion& motion) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.outputs.size()));
  Eigen::VectorXd squares = sum;
  Eigen::VectorXd count = sum;
  double attitudes = 0.0;
  for (std::size_t k = 0; k < motion.segment_count; ++k) {
    const Segment& segment = problem.segments[motion.first_segment + k];
    for (const Observation& o : segment.observations) {
      const double value = o.value / problem.outputs[static_cast<std::size_t>(o.output)].scale;
      sum[o.output] += value;
      squares[o.output] += value * value;
      count[o.output] += 1.0;
    }
    if (problem.attitude_scale) {
      attitudes += static_cast<double>(segment.attitudes.size()) / std::pow(*problem.attitude_scale, 2);
    }
  }
  return attitudes + (squares.array() - sum.array().square() / count.array().max(1.0)).max(0.0).sum();
}

/// Smallest diagonal of J^T J that counts as influence, per coordinate; none of what has no box.
Eigen::VectorXd influence_floor(const std::vector<FitCoordinate>& coordinates, const std::vector<int>& free,
                                double total_spread) {
  Eigen::VectorXd floor = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(free.size()));
  for (std::size_t k = 0; k < free.size(); ++k) {
    if (static_cast<std::size_t>(free[k]) >= coordinates.size()) continue;  // an offset
    const FitCoordinate& c = coordinates[static_cast<std::size_t>(free[k])];
    floor[static_cast<Eigen::Index>(k)] = kNoInfluence * total_spread / std::pow(c.upper - c.lower, 2);
  }
  return floor;
}

/// The equations of all segments of a motion, one below the other; own unknowns by the directions in which
/// they can move, segment after segment.
struct MotionEquations {
  Eigen::MatrixXd by_shared, by_own;
  Eigen::VectorXd psi, dpsi;   ///< of priors and joins: the residual, and one
  Eigen::MatrixXd own_priors;  ///< J^T J of the priors' rows
  double psi_squares = 0.0;    ///< of data alone
  double dpsi_sum = 0.0;
};

MotionEquations motion_equations(const FitProblem& problem, const Motion& motion,
                                 const std::vector<SegmentResidual>& residuals, const FitPoint& point) {
  const int directions = problem.own_chart.directions();
  Eigen::Index rows = 0;
  for (std::size_t k = 0; k < motion.segment_count; ++k) rows += residuals[motion.first_segment + k].size();
  MotionEquations result;
  result.by_shared.resize(rows, problem.shared_count());
  result.by_own.setZero(rows, directions * static_cast<Eigen::Index>(motion.segment_count));
  result.psi.resize(rows);
  result.dpsi.setOnes(rows);
  result.own_priors.setZero(result.by_own.cols(), result.by_own.cols());
  Eigen::Index first = 0;
  for (std::size_t k = 0; k < motion.segment_count; ++k) {
    const std::size_t at = motion.first_segment + k;
    const SegmentResidual& residual = residuals[at];
    const Eigen::Index column = directions * static_cast<Eigen::Index>(k);
    result.by_shared.middleRows(first, residual.size()) = residual.by_shared();
    result.by_own.block(first, column, residual.size(), directions) =
        residual.by_own() * problem.own_chart.plus_jacobian(point.own[at].data());
    if (residual.segment().joined) {
      result.by_own.block(first, column + directions, residual.size(), directions) =
          residual.by_next() * problem.own_chart.plus_jacobian(point.own[at + 1].data());
    }
    const auto priors = result.by_own.middleRows(first + residual.data_size(), residual.prior_size());
    result.own_priors += priors.transpose() * priors;
    for (Eigen::Index row = 0; row < residual.size(); ++row) {
      result.psi[first + row] = residual.residual()[row];
      if (row >= residual.data_size()) continue;
      const LossValue value = loss_value(problem.loss, residual.residual()[row]);
      result.psi[first + row] = value.psi;
      result.dpsi[first + row] = value.dpsi;
      result.psi_squares += value.psi * value.psi;
      result.dpsi_sum += value.dpsi;
    }
    first += residual.size();
  }
  return result;
}

/// What one motion says, its own unknowns eliminated.
struct MotionTerms {
  std::vector<int> own_free;               ///< directions, over all segments
  DeterminedInverse own_inverse;           ///< of J_o^T J_o
  Eigen::MatrixXd own_priors;              ///< of that, what priors add
  Eigen::MatrixXd projection;              ///< (J_o^T J_o)^-1 J_o^T J_s
  Eigen::VectorXd shared_diagonal_before;  ///< of J_s^T J_s
  Eigen::MatrixXd normal;                  ///< J_s^T J_s without what the own unknowns explain
  Eigen::MatrixXd hessian;                 ///< the same weighed by psi'
  Eigen::VectorXd score;                   ///< gradient of the cost
  bool hessian_usable = true;
  double psi_squares = 0.0;
  double dpsi_sum = 0.0;
};

/// What a join determines, it determines from what was measured: no floor from the box is needed there.
Eigen::VectorXd own_floor(const FitProblem& problem, const Motion& motion, const std::vector<int>& own) {
  if (motion.segment_count > 1 || !problem.own_chart.is_linear()) {
    return Eigen::VectorXd::Zero(static_cast<Eigen::Index>(own.size()));
  }
  return influence_floor(problem.own, own, spread(problem, motion));
}

MotionTerms motion_terms(const FitProblem& problem, const Motion& motion,
                         const std::vector<SegmentResidual>& residuals, const FitPoint& point,
                         const std::vector<int>& own) {
  const MotionEquations equations = motion_equations(problem, motion, residuals, point);
  MotionTerms terms;
  terms.own_free = own;
  const Eigen::MatrixXd& J_s = equations.by_shared;
  const Eigen::MatrixXd J_o = equations.by_own(Eigen::all, own);
  const Eigen::VectorXd& dpsi = equations.dpsi;
  terms.psi_squares = equations.psi_squares;
  terms.dpsi_sum = equations.dpsi_sum;

  terms.own_priors = equations.own_priors(own, own);
  terms.own_inverse = invert_determined(J_o.transpose() * J_o, own_floor(problem, motion, own));
  terms.projection = terms.own_inverse.inverse * (J_o.transpose() * J_s);
  const Eigen::MatrixXd rest = J_s - J_o * terms.projection;
  terms.shared_diagonal_before = J_s.colwise().squaredNorm().transpose();
  terms.normal = rest.transpose() * rest;

  const Eigen::MatrixXd H_oo = J_o.transpose() * dpsi.asDiagonal() * J_o;
  const Eigen::MatrixXd H_os = J_o.transpose() * dpsi.asDiagonal() * J_s;
  terms.hessian = J_s.transpose() * dpsi.asDiagonal() * J_s;
  terms.score = J_s.transpose() * equations.psi;
  if (own.empty() || J_s.cols() == 0) return terms;
  const Eigen::LLT<Eigen::MatrixXd> factor(H_oo);
  terms.hessian_usable = factor.info() == Eigen::Success && factor.rcond() > 1e-14;
  if (!terms.hessian_usable) return terms;
  terms.hessian -= H_os.transpose() * factor.solve(H_os);
  terms.score -= H_os.transpose() * factor.solve(J_o.transpose() * equations.psi);
  return terms;
}

/// Sums over all motions, and the priors.
struct Totals {
  Eigen::MatrixXd normal, hessian;  ///< without priors
  Eigen::MatrixXd priors;           ///< what they add to the Hessian
  Eigen::VectorXd diagonal_before;
  Eigen::MatrixXd cluster_scores;  ///< shared x clusters
  bool hessian_usable = true;
  double psi_squares = 0.0, dpsi_sum = 0.0, spread = 0.0;
  double mean_dpsi = 0.0;
  int own_unknowns = 0;  ///< not at bounds

  /// The Hessian with the priors, and what stands in for it: mean(psi') J^T J, in units of mean(psi').
  Eigen::MatrixXd full_hessian() const { return hessian + priors; }
  Eigen::MatrixXd full_normal() const { return normal + priors / std::max(mean_dpsi, kLeastSlope); }
};

/// What priors, of single coordinates and of combinations, add to the Hessian.
Eigen::MatrixXd prior_information(const FitProblem& problem, const FitPoint& point) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(problem.shared_count(), problem.shared_count());
  for (const SharedPrior& prior : problem.priors) {
    const double derivative = prior_residual(prior.prior, point.shared[prior.shared]).derivative;
    sum(prior.shared, prior.shared) += derivative * derivative;
  }
  for (const SharedCombination& combination : problem.combinations) {
    for (const auto& [row, a] : combination.terms) {
      for (const auto& [column, b] : combination.terms) {
        sum(row, column) += a * b / (combination.deviation * combination.deviation);
      }
    }
  }
  return sum;
}

Totals add_up(const FitProblem& problem, const std::vector<MotionTerms>& terms, const FitPoint& point) {
  Totals sum;
  const Eigen::Index shared_count = problem.shared_count();
  sum.normal.setZero(shared_count, shared_count);
  sum.hessian = sum.normal;
  sum.diagonal_before.setZero(shared_count);
  sum.cluster_scores.setZero(shared_count, problem.cluster_count);
  for (std::size_t c = 0; c < terms.size(); ++c) {
    sum.normal += terms[c].normal;
    sum.hessian += terms[c].hessian;
    sum.diagonal_before += terms[c].shared_diagonal_before;
    sum.cluster_scores.col(problem.motions[c].cluster) += terms[c].score;
    sum.hessian_usable = sum.hessian_usable && terms[c].hessian_usable;
    sum.psi_squares += terms[c].psi_squares;
    sum.dpsi_sum += terms[c].dpsi_sum;
    sum.spread += spread(problem, problem.motions[c]);
    // Each joined segment brings as many conditions as unknowns.
    const auto joined = static_cast<int>(problem.motions[c].segment_count) - 1;
    sum.own_unknowns += static_cast<int>(terms[c].own_free.size()) - joined * problem.join_rows();
  }
  sum.priors = prior_information(problem, point);
  sum.mean_dpsi = sum.dpsi_sum / problem.observation_count();
  return sum;
}

/// Variance of a residual as Huber's formula has it: var(psi)/mean(psi')^2. NaN if nothing is left over.
double naive_variance(const FitProblem& problem, const Totals& sum, int unknowns) {
  const int count = problem.observation_count();
  if (count <= unknowns || sum.mean_dpsi <= kLeastSlope) return kNaN;
  return sum.psi_squares / (count - unknowns) / (sum.mean_dpsi * sum.mean_dpsi);
}

/// Huber's covariance of the free unknowns. What frames say varies as their residuals do; what was known
/// beforehand, by its own deviation: with the weight m = mean(psi') of frames and K = (J^T J + P/m)^-1,
///
///     K (variance J^T J + P/m^2) K.
Eigen::MatrixXd naive_covariance(const Totals& sum, const std::vector<int>& free, const Eigen::MatrixXd& K,
                                 double variance) {
  const double m = std::max(sum.mean_dpsi, kLeastSlope);
  return variance * K + (1.0 / m - variance) / m * (K * sum.priors(free, free) * K);
}

/// H^-1 (C/(C - 1) sum_c g_c g_c^T + P) H^-1.
Eigen::MatrixXd sandwich(const Eigen::MatrixXd& inverse_hessian, const Eigen::MatrixXd& scores,
                         const Eigen::MatrixXd& priors) {
  const auto clusters = static_cast<double>(scores.cols());
  const Eigen::MatrixXd moved = inverse_hessian * scores;
  return clusters / (clusters - 1.0) * moved * moved.transpose() + inverse_hessian * priors * inverse_hessian;
}

/// Of the free directions of a motion: with the shared unknowns known, and what their errors bring along.
Eigen::MatrixXd own_covariance(const MotionTerms& terms, const Eigen::MatrixXd& shared, double variance) {
  const Eigen::MatrixXd& K = terms.own_inverse.inverse;
  return variance * K + (1.0 - variance) * K * terms.own_priors * K +
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

/// The clustered covariance of the free unknowns. Where the Hessian of the loss does not serve, mean(psi')
/// J^T J stands in, and `replaced` says so.
Eigen::MatrixXd clustered_covariance(const FitProblem& problem, const Totals& sum,
                                     const std::vector<int>& free, const DeterminedInverse& inverse,
                                     bool& replaced) {
  const auto count = static_cast<Eigen::Index>(free.size());
  if (problem.cluster_count < 2 || count == 0) return Eigen::MatrixXd::Constant(count, count, kNaN);
  const Eigen::MatrixXd scores = sum.cluster_scores(free, Eigen::all);
  const Eigen::MatrixXd priors = sum.priors(free, free);
  const Eigen::LLT<Eigen::MatrixXd> hessian(sum.full_hessian()(free, free));
  replaced = !sum.hessian_usable || hessian.info() != Eigen::Success;
  if (!replaced && inverse.all_determined()) {
    return sandwich(hessian.solve(Eigen::MatrixXd::Identity(count, count)), scores, priors);
  }
  if (sum.mean_dpsi <= kLeastSlope) return Eigen::MatrixXd::Constant(count, count, kNaN);
  return sandwich(inverse.inverse / sum.mean_dpsi, scores, priors);
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
                                 const FitPoint& point) {
  Uncertainty result;
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    const double* next = residuals[k].segment().joined ? point.own[k + 1].data() : nullptr;
    residuals[k].evaluate(point.shared.data(), point.own[k].data(), next, true);
  }
  std::vector<MotionTerms> terms;
  for (const Motion& motion : problem.motions) {
    terms.push_back(motion_terms(problem, motion, residuals, point, free_directions(problem, motion, point)));
  }
  const Totals sum = add_up(problem, terms, point);

  // Those at a bound are asked too: an unknown without influence may have drifted there. What is left of one
  // beside the own unknowns must also stand out of rounding.
  const Eigen::VectorXd floor =
      influence_floor(problem.shared, free_indices(std::vector<char>(problem.shared.size(), 0)), sum.spread)
          .cwiseMax(kNoInfluence * sum.diagonal_before);
  const Eigen::MatrixXd normal = sum.full_normal();
  const DeterminedInverse whole = invert_determined(normal, floor);
  result.determined = whole.determined;
  result.undetermined_sets = whole.undetermined_sets;
  if (whole.all_determined() && !problem.priors.empty() && problem.combinations.empty()) {
    result.sets_held_by_priors = invert_determined(sum.normal, floor).undetermined_sets;
  }
  result.at_bound = at_bounds(problem.shared, problem.shared_chart, point.shared);

  const std::vector<int> free = free_indices(result.at_bound);
  const Eigen::Index all = problem.shared_count();
  const DeterminedInverse inverse = invert_determined(normal(free, free), floor(free));
  const int unknowns = static_cast<int>(free.size()) + sum.own_unknowns;
  const double variance = naive_variance(problem, sum, unknowns);
  result.naive = scattered(naive_covariance(sum, free, inverse.inverse, variance), free, all);
  result.information = information_of(sum);
  result.dispersion = variance * sum.mean_dpsi;
  result.residual_freedom = problem.observation_count() - unknowns;
  result.clustered =
      scattered(clustered_covariance(problem, sum, free, inverse, result.hessian_replaced), free, all);
  for (std::size_t c = 0; c < terms.size(); ++c) {
    const Eigen::MatrixXd covariance = own_covariance(terms[c], result.naive, variance);
    for (std::size_t k = 0; k < problem.motions[c].segment_count; ++k) {
      const Eigen::VectorXd& own = point.own[problem.motions[c].first_segment + k];
      result.own.push_back(
          own_uncertainty(problem, terms[c], covariance, k, own, own_at_bounds(problem, own)));
    }
  }

  std::vector<char> has_error = result.determined;
  for (std::size_t k = 0; k < has_error.size(); ++k) has_error[k] = has_error[k] && !result.at_bound[k];
  hide(has_error, result.naive);
  hide(has_error, result.clustered);
  return result;
}

}  // namespace samara::identification
