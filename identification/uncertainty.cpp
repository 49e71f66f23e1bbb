#include "samara/identification/uncertainty.h"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "samara/identification/determined_inverse.h"
#include "samara/identification/loss.h"

namespace samara::identification {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Influence on the residuals over the whole box, relative to the spread of the measurements, squared: below
/// it there is none.
constexpr double kNoInfluence = 1e-14;

std::vector<char> at_bounds(const std::vector<FitCoordinate>& coordinates, const Eigen::VectorXd& values) {
  std::vector<char> at(static_cast<std::size_t>(values.size()), 0);
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    const FitCoordinate& c = coordinates[k];
    const double value = values[static_cast<Eigen::Index>(k)];
    const double margin = 1e-7 * (c.upper - c.lower);
    at[k] = value <= c.lower + margin || value >= c.upper - margin;
  }
  return at;
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
double spread(const FitProblem& problem, const Segment& segment) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.outputs.size()));
  Eigen::VectorXd squares = sum;
  Eigen::VectorXd count = sum;
  for (const Observation& o : segment.observations) {
    const double value = o.value / problem.outputs[static_cast<std::size_t>(o.output)].scale;
    sum[o.output] += value;
    squares[o.output] += value * value;
    count[o.output] += 1.0;
  }
  return (squares.array() - sum.array().square() / count.array().max(1.0)).max(0.0).sum();
}

/// Smallest diagonal of J^T J that counts as influence, per coordinate.
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

/// What one segment says, its own unknowns eliminated.
struct SegmentTerms {
  std::vector<int> own_free;
  DeterminedInverse own_inverse;           ///< of J_o^T J_o
  Eigen::MatrixXd projection;              ///< (J_o^T J_o)^-1 J_o^T J_s
  Eigen::VectorXd shared_diagonal_before;  ///< of J_s^T J_s
  Eigen::MatrixXd normal;                  ///< J_s^T J_s without what the own unknowns explain
  Eigen::MatrixXd hessian;                 ///< the same weighed by psi'
  Eigen::VectorXd score;                   ///< gradient of the cost
  bool hessian_usable = true;
  double psi_squares = 0.0;
  double dpsi_sum = 0.0;
};

SegmentTerms segment_terms(const FitProblem& problem, const SegmentResidual& residual,
                           const std::vector<int>& own) {
  SegmentTerms terms;
  terms.own_free = own;
  const Eigen::MatrixXd& J_s = residual.by_shared();
  const Eigen::MatrixXd J_o = residual.by_own()(Eigen::all, own);
  Eigen::VectorXd psi(residual.size());
  Eigen::VectorXd dpsi(residual.size());
  for (Eigen::Index row = 0; row < psi.size(); ++row) {
    const LossValue value = loss_value(problem.loss, residual.residual()[row]);
    psi[row] = value.psi;
    dpsi[row] = value.dpsi;
  }
  terms.psi_squares = psi.squaredNorm();
  terms.dpsi_sum = dpsi.sum();

  const double own_spread = spread(problem, residual.segment());
  terms.own_inverse = invert_determined(J_o.transpose() * J_o, influence_floor(problem.own, own, own_spread));
  terms.projection = terms.own_inverse.inverse * (J_o.transpose() * J_s);
  const Eigen::MatrixXd rest = J_s - J_o * terms.projection;
  terms.shared_diagonal_before = J_s.colwise().squaredNorm().transpose();
  terms.normal = rest.transpose() * rest;

  const Eigen::MatrixXd H_oo = J_o.transpose() * dpsi.asDiagonal() * J_o;
  const Eigen::MatrixXd H_os = J_o.transpose() * dpsi.asDiagonal() * J_s;
  terms.hessian = J_s.transpose() * dpsi.asDiagonal() * J_s;
  terms.score = J_s.transpose() * psi;
  if (own.empty() || J_s.cols() == 0) return terms;
  const Eigen::LLT<Eigen::MatrixXd> factor(H_oo);
  terms.hessian_usable = factor.info() == Eigen::Success && factor.rcond() > 1e-14;
  if (!terms.hessian_usable) return terms;
  terms.hessian -= H_os.transpose() * factor.solve(H_os);
  terms.score -= H_os.transpose() * factor.solve(J_o.transpose() * psi);
  return terms;
}

/// Sums over all segments.
struct Totals {
  Eigen::MatrixXd normal, hessian;
  Eigen::VectorXd diagonal_before;
  Eigen::MatrixXd cluster_scores;  ///< shared x clusters
  bool hessian_usable = true;
  double psi_squares = 0.0, dpsi_sum = 0.0, spread = 0.0;
  int own_unknowns = 0;  ///< not at bounds
};

Totals add_up(const FitProblem& problem, const std::vector<SegmentTerms>& terms) {
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
    sum.cluster_scores.col(problem.segments[c].cluster) += terms[c].score;
    sum.hessian_usable = sum.hessian_usable && terms[c].hessian_usable;
    sum.psi_squares += terms[c].psi_squares;
    sum.dpsi_sum += terms[c].dpsi_sum;
    sum.spread += spread(problem, problem.segments[c]);
    sum.own_unknowns += static_cast<int>(terms[c].own_free.size());
  }
  return sum;
}

/// Variance of a residual as Huber's formula has it: var(psi)/mean(psi')^2. NaN if nothing is left over.
double naive_variance(const FitProblem& problem, const Totals& sum, int unknowns) {
  const int count = problem.observation_count();
  const double mean_dpsi = sum.dpsi_sum / count;
  if (count <= unknowns || mean_dpsi <= 0.0) return kNaN;
  return sum.psi_squares / (count - unknowns) / (mean_dpsi * mean_dpsi);
}

/// H^-1 (sum_c g_c g_c^T) H^-1 C/(C - 1).
Eigen::MatrixXd sandwich(const Eigen::MatrixXd& inverse_hessian, const Eigen::MatrixXd& scores) {
  const auto clusters = static_cast<double>(scores.cols());
  const Eigen::MatrixXd moved = inverse_hessian * scores;
  return clusters / (clusters - 1.0) * moved * moved.transpose();
}

/// @param shared_inverse (J_s^T J_s)^-1, zero for shared unknowns that are held
OwnUncertainty own_uncertainty(const SegmentTerms& terms, std::vector<char> at_bound,
                               const Eigen::MatrixXd& shared_inverse, double variance) {
  OwnUncertainty own;
  const auto count = static_cast<Eigen::Index>(at_bound.size());
  own.at_bound = std::move(at_bound);
  own.standard_error.setConstant(count, kNaN);
  own.determined.assign(own.at_bound.size(), 1);
  const Eigen::MatrixXd covariance =
      variance *
      (terms.own_inverse.inverse + terms.projection * shared_inverse * terms.projection.transpose());
  for (std::size_t k = 0; k < terms.own_free.size(); ++k) {
    const auto place = static_cast<std::size_t>(terms.own_free[k]);
    const auto at = static_cast<Eigen::Index>(k);
    own.determined[place] = terms.own_inverse.determined[k];
    if (own.determined[place]) own.standard_error[terms.own_free[k]] = std::sqrt(covariance(at, at));
  }
  return own;
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
  const Eigen::LLT<Eigen::MatrixXd> hessian(sum.hessian(free, free));
  replaced = !sum.hessian_usable || hessian.info() != Eigen::Success;
  if (!replaced && inverse.all_determined()) {
    return sandwich(hessian.solve(Eigen::MatrixXd::Identity(count, count)), scores);
  }
  const double mean_dpsi = sum.dpsi_sum / problem.observation_count();
  if (mean_dpsi <= 0.0) return Eigen::MatrixXd::Constant(count, count, kNaN);
  return sandwich(inverse.inverse / mean_dpsi, scores);
}

/// The Hessian of the cost where it is one of a minimum, else what stands in for it.
Eigen::MatrixXd information_of(const FitProblem& problem, const Totals& sum) {
  const Eigen::LLT<Eigen::MatrixXd> factor(sum.hessian);
  if (sum.hessian_usable && factor.info() == Eigen::Success) return sum.hessian;
  const double mean_dpsi = sum.dpsi_sum / problem.observation_count();
  return mean_dpsi > 0.0 ? Eigen::MatrixXd(mean_dpsi * sum.normal) : sum.normal;
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
  std::vector<SegmentTerms> terms;
  for (std::size_t c = 0; c < residuals.size(); ++c) {
    residuals[c].evaluate(point.shared.data(), point.own[c].data(), true);
    terms.push_back(segment_terms(problem, residuals[c], free_indices(at_bounds(problem.own, point.own[c]))));
  }
  const Totals sum = add_up(problem, terms);

  // Those at a bound are asked too: an unknown without influence may have drifted there. What is left of one
  // beside the own unknowns must also stand out of rounding.
  const Eigen::VectorXd floor =
      influence_floor(problem.shared, free_indices(std::vector<char>(problem.shared.size(), 0)), sum.spread)
          .cwiseMax(kNoInfluence * sum.diagonal_before);
  const DeterminedInverse whole = invert_determined(sum.normal, floor);
  result.determined = whole.determined;
  result.undetermined_sets = whole.undetermined_sets;
  result.at_bound = at_bounds(problem.shared, point.shared);

  const std::vector<int> free = free_indices(result.at_bound);
  const Eigen::Index all = problem.shared_count();
  const DeterminedInverse inverse = invert_determined(sum.normal(free, free), floor(free));
  const Eigen::MatrixXd normal_inverse = scattered(inverse.inverse, free, all);
  const double variance = naive_variance(problem, sum, static_cast<int>(free.size()) + sum.own_unknowns);
  result.naive = variance * normal_inverse;
  result.information = information_of(problem, sum);
  result.dispersion = variance * sum.dpsi_sum / problem.observation_count();
  result.clustered =
      scattered(clustered_covariance(problem, sum, free, inverse, result.hessian_replaced), free, all);

  std::vector<char> has_error = result.determined;
  for (std::size_t k = 0; k < has_error.size(); ++k) has_error[k] = has_error[k] && !result.at_bound[k];
  hide(has_error, result.naive);
  hide(has_error, result.clustered);
  for (std::size_t c = 0; c < terms.size(); ++c) {
    result.own.push_back(
        own_uncertainty(terms[c], at_bounds(problem.own, point.own[c]), normal_inverse, variance));
  }
  return result;
}

}  // namespace samara::identification
