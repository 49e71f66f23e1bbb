#include "samara/identification/solve/motion_terms.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "samara/base/parallel.h"
#include "samara/identification/problem/box_bounds.h"
#include "samara/identification/statistics/loss.h"

namespace samara::identification {

std::vector<char> own_at_bounds(const FitProblem& problem, const Eigen::VectorXd& own) {
  return at_bounds(problem.own, problem.own_chart, own);
}

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

BoundedDirections bounded_directions(const FitProblem& problem, const Motion& motion, const FitPoint& point) {
  const int directions = problem.own_chart.directions();
  BoundedDirections result;
  for (int k = 0; k < directions * static_cast<int>(motion.segment_count); ++k) result.all.push_back(k);
  result.information.setZero(static_cast<Eigen::Index>(result.all.size()));
  for (std::size_t k = 0; k < motion.segment_count; ++k) {
    const std::vector<char> held = own_at_bounds(problem, point.own[motion.first_segment + k]);
    for (std::size_t u = 0; u < held.size(); ++u) {
      const int direction = problem.own_chart.direction_of(static_cast<int>(u));
      if (!held[u] || direction < 0) continue;
      const double width = problem.own[u].upper - problem.own[u].lower;
      result.information[directions * static_cast<Eigen::Index>(k) + direction] = 12.0 / (width * width);
      result.any = true;
    }
  }
  return result;
}

std::vector<int> free_indices(const std::vector<char>& at_bound) {
  std::vector<int> indices;
  for (std::size_t k = 0; k < at_bound.size(); ++k) {
    if (!at_bound[k]) indices.push_back(static_cast<int>(k));
  }
  return indices;
}

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

Eigen::VectorXd influence_floor(const std::vector<models::FamilyCoordinate>& coordinates,
                                const std::vector<int>& free, double total_spread) {
  Eigen::VectorXd floor = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(free.size()));
  for (std::size_t k = 0; k < free.size(); ++k) {
    if (static_cast<std::size_t>(free[k]) >= coordinates.size()) continue;  // an offset
    const models::FamilyCoordinate& c = coordinates[static_cast<std::size_t>(free[k])];
    floor[static_cast<Eigen::Index>(k)] = kNoInfluence * total_spread / std::pow(c.upper - c.lower, 2);
  }
  return floor;
}

bool evaluate_all(std::vector<SegmentResidual>& residuals, const FitPoint& point) {
  std::vector<char> ok(residuals.size(), 0);
  parallel_for(residuals.size(), [&](std::size_t k) {
    const double* next = residuals[k].segment().joined ? point.own[k + 1].data() : nullptr;
    ok[k] = residuals[k].evaluate(point.shared.data(), point.own[k].data(), next, true);
  });
  return std::ranges::all_of(ok, [](char one) { return one != 0; });
}

MotionEquations motion_equations(const FitProblem& problem, const Motion& motion,
                                 const std::vector<SegmentResidual>& residuals, const FitPoint& point) {
  const int directions = problem.own_chart.directions();
  Eigen::Index rows = 0;
  for (std::size_t k = 0; k < motion.segment_count; ++k) rows += residuals[motion.first_segment + k].size();
  MotionEquations result;
  result.by_shared.resize(rows, problem.shared_count());
  result.by_own.setZero(rows, directions * static_cast<Eigen::Index>(motion.segment_count));
  result.residual.resize(rows);
  result.psi.resize(rows);
  result.dpsi.setOnes(rows);
  result.is_data.setZero(rows);
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
      result.residual[first + row] = residual.residual()[row];
      result.psi[first + row] = residual.residual()[row];
      if (row >= residual.data_size()) continue;
      const LossValue value = loss_value(problem.loss, residual.residual()[row]);
      result.psi[first + row] = value.psi;
      result.dpsi[first + row] = value.dpsi;
      result.is_data[first + row] = 1.0;
      result.psi_squares += value.psi * value.psi;
      result.dpsi_sum += value.dpsi;
    }
    first += residual.size();
  }
  return result;
}

namespace {

/// What a join determines, it determines from what was measured: no floor from the box is needed there.
Eigen::VectorXd own_floor(const FitProblem& problem, const Motion& motion, const std::vector<int>& own) {
  if (motion.segment_count > 1 || !problem.own_chart.is_linear()) {
    return Eigen::VectorXd::Zero(static_cast<Eigen::Index>(own.size()));
  }
  return influence_floor(problem.own, own, spread(problem, motion));
}

}  // namespace

double mean_slope(const FitProblem& problem, const std::vector<SegmentResidual>& residuals) {
  double sum = 0.0;
  for (const SegmentResidual& residual : residuals) {
    for (int row = 0; row < residual.data_size(); ++row)
      sum += loss_value(problem.loss, residual.residual()[row]).dpsi;
  }
  return sum / problem.observation_count();
}

PriorTerms prior_terms(const FitProblem& problem, const FitPoint& point) {
  const Eigen::Index count = problem.shared_count();
  PriorTerms sum{.gradient = Eigen::VectorXd::Zero(count),
                 .information = Eigen::MatrixXd::Zero(count, count)};
  for (const PriorTerm& prior : problem.priors) {
    const double residual = prior.residual(point.shared.data());
    const double slope = prior.slope(point.shared.data());
    sum.cost += 0.5 * residual * residual;
    for (const auto& [row, a] : prior.weights()) {
      sum.gradient[row] += residual * a * slope;
      for (const auto& [column, b] : prior.weights()) sum.information(row, column) += a * b * slope * slope;
    }
  }
  return sum;
}

MotionTerms motion_terms(const FitProblem& problem, const Motion& motion,
                         const std::vector<SegmentResidual>& residuals, const FitPoint& point, double slope,
                         const std::vector<int>& own, const Eigen::VectorXd& own_information) {
  const MotionEquations equations = motion_equations(problem, motion, residuals, point);
  MotionTerms terms;
  terms.own_free = own;
  const Eigen::MatrixXd& J_s = equations.by_shared;
  const Eigen::MatrixXd J_o = equations.by_own(Eigen::all, own);
  const Eigen::VectorXd& dpsi = equations.dpsi;
  terms.psi_squares = equations.psi_squares;

  Eigen::MatrixXd known = Eigen::MatrixXd::Zero(J_o.cols(), J_o.cols());
  if (own_information.size() > 0) known.diagonal() = own_information;
  // J_o^T J_o has the priors with a weight of 1 already.
  const Eigen::MatrixXd priors = equations.own_priors(own, own);
  terms.own_priors = (priors + known) / std::max(slope, kLeastSlope);
  const Eigen::MatrixXd beside = terms.own_priors - priors;
  terms.own_inverse = invert_determined(J_o.transpose() * J_o + beside, own_floor(problem, motion, own));
  terms.projection = terms.own_inverse.inverse * (J_o.transpose() * J_s);
  const Eigen::MatrixXd rest = J_s - J_o * terms.projection;
  terms.shared_diagonal_before = J_s.colwise().squaredNorm().transpose();
  terms.normal = rest.transpose() * rest + terms.projection.transpose() * beside * terms.projection;
  terms.prior_part = terms.projection.transpose() * terms.own_priors * terms.projection;
  const Eigen::VectorXd leverage = (J_o * terms.own_inverse.inverse).cwiseProduct(J_o).rowwise().sum();
  terms.own_unknowns = leverage.dot(equations.is_data);

  const Eigen::MatrixXd H_oo = J_o.transpose() * dpsi.asDiagonal() * J_o + known;
  const Eigen::MatrixXd H_os = J_o.transpose() * dpsi.asDiagonal() * J_s;
  terms.hessian = J_s.transpose() * dpsi.asDiagonal() * J_s;
  terms.score = J_s.transpose() * equations.psi;
  if (own.empty() || J_s.cols() == 0) return terms;
  const Eigen::LLT<Eigen::MatrixXd> factor(H_oo);
  terms.hessian_usable = factor.info() == Eigen::Success && factor.rcond() > 1e-14;
  if (!terms.hessian_usable) {
    terms.score -= terms.projection.transpose() * (J_o.transpose() * equations.psi);
    return terms;
  }
  terms.hessian -= H_os.transpose() * factor.solve(H_os);
  terms.score -= H_os.transpose() * factor.solve(Eigen::VectorXd(J_o.transpose() * equations.psi));
  return terms;
}

}  // namespace samara::identification
