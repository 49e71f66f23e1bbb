#include "samara/identification/solve/posterior_density.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "samara/identification/statistics/loss.h"

namespace samara::identification {

namespace {

constexpr double kImpossible = std::numeric_limits<double>::infinity();

void add_boxed(const std::vector<models::FamilyCoordinate>& box, const Chart& chart, bool is_shared,
               std::size_t segment, int first, std::vector<BoxedDirection>& all) {
  for (std::size_t k = 0; k < box.size(); ++k) {
    const int unknown = static_cast<int>(k), direction = chart.direction_of(unknown);
    if (direction < 0 || chart.is_part_of_quaternion(unknown)) continue;
    const bool by_factor = chart.is_logarithmic(unknown);
    const double lower = by_factor ? std::log(box[k].lower) : box[k].lower;
    const double upper = by_factor ? std::log(box[k].upper) : box[k].upper;
    if (!std::isfinite(upper - lower)) continue;
    all.push_back({first + direction, segment, is_shared, by_factor, unknown, lower, upper});
  }
}

std::vector<BoxedDirection> boxed_directions(const FitProblem& problem, const DirectionLayout& layout) {
  std::vector<BoxedDirection> all;
  add_boxed(problem.shared, problem.shared_chart, true, 0, 0, all);
  for (std::size_t k = 0; k < problem.segments.size(); ++k)
    add_boxed(problem.own, problem.own_chart, false, k, layout.first_of(k), all);
  return all;
}

}  // namespace

double BoxedDirection::place(const FitPoint& point) const {
  const double value = is_shared ? point.shared[unknown] : point.own[segment][unknown];
  return is_logarithmic ? std::log(value) : value;
}

double BoxedDirection::time_to_wall(const FitPoint& point, double velocity) const {
  if (velocity == 0.0) return kImpossible;
  return std::max((velocity > 0.0 ? upper - place(point) : lower - place(point)) / velocity, 0.0);
}

PosteriorDensity::PosteriorDensity(const models::TrajectoryFamily& family, const FitProblem& problem,
                                   const std::vector<SegmentResidual>& residuals, double dispersion)
    : problem_(problem),
      layout_(problem),
      boxed_(boxed_directions(problem, layout_)),
      dispersion_(dispersion),
      residuals_(make_residuals(family, problem, residuals)) {}

double PosteriorDensity::operator()(const FitPoint& point, Eigen::VectorXd& slope) {
  for (std::size_t k = 0; k < residuals_.size(); ++k) {
    const double* next = residuals_[k].segment().joined ? point.own[k + 1].data() : nullptr;
    if (!residuals_[k].evaluate(point.shared.data(), point.own[k].data(), next, true)) return kImpossible;
  }
  slope.setZero(layout_.all);
  const PriorTerms priors = prior_terms(problem_, point);
  Eigen::VectorXd by_shared = priors.gradient;
  double sum = priors.cost;
  for (const Motion& motion : problem_.motions) {
    const MotionEquations equations = motion_equations(problem_, motion, residuals_, point);
    const Eigen::VectorXd weighted = equations.psi.cwiseProduct(weights(equations));
    sum += cost(equations);
    by_shared += equations.by_shared.transpose() * weighted;
    slope.segment(layout_.first_of(motion.first_segment), equations.by_own.cols()) +=
        equations.by_own.transpose() * weighted;
  }
  slope.head(layout_.shared) =
      problem_.shared_chart.plus_jacobian(point.shared.data()).transpose() * by_shared;
  return sum;
}

std::string PosteriorDensity::failure() const {
  std::string failure = failure_of(residuals_);
  return failure.empty() ? "the cost is not a finite number" : failure;
}

Eigen::MatrixXd PosteriorDensity::normal_matrix(const FitPoint& point, bool by_slope) const {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(layout_.all, layout_.all);
  const Eigen::MatrixXd moves = problem_.shared_chart.plus_jacobian(point.shared.data());
  sum.topLeftCorner(layout_.shared, layout_.shared) =
      moves.transpose() * prior_terms(problem_, point).information * moves;
  for (const Motion& motion : problem_.motions) {
    const MotionEquations equations = motion_equations(problem_, motion, residuals_, point);
    Eigen::VectorXd weight = weights(equations);
    for (Eigen::Index row = 0; row < weight.size(); ++row) {
      if (!by_slope) {
        weight[row] *= equations.dpsi[row];
      } else if (equations.residual[row] != 0.0) {
        weight[row] *= equations.psi[row] / equations.residual[row];
      }
    }
    const Eigen::MatrixXd by_shared = equations.by_shared * moves;
    const int first = layout_.first_of(motion.first_segment);
    const Eigen::Index own = equations.by_own.cols();
    const Eigen::MatrixXd weighted = weight.asDiagonal() * equations.by_own;
    sum.topLeftCorner(layout_.shared, layout_.shared) +=
        by_shared.transpose() * weight.asDiagonal() * by_shared;
    sum.block(0, first, layout_.shared, own) += by_shared.transpose() * weighted;
    sum.block(first, 0, own, layout_.shared) += weighted.transpose() * by_shared;
    sum.block(first, first, own, own) += equations.by_own.transpose() * weighted;
  }
  return sum;
}

Eigen::MatrixXd PosteriorDensity::second_derivative(const FitPoint& point) const {
  return normal_matrix(point, false);
}

PosteriorDensity::DataCost PosteriorDensity::data_cost(const FitPoint& point) const {
  DataCost result;
  for (const Motion& motion : problem_.motions) {
    const MotionEquations equations = motion_equations(problem_, motion, residuals_, point);
    for (Eigen::Index row = 0; row < equations.residual.size(); ++row) {
      if (!(equations.is_data[row] > 0.0)) continue;
      result.cost += 0.5 * loss_value(problem_.loss, equations.residual[row]).rho;
      ++result.values;
    }
  }
  return result;
}

Eigen::MatrixXd PosteriorDensity::curvature(const FitPoint& point) const {
  Eigen::MatrixXd sum = normal_matrix(point, true);
  Eigen::VectorXd beside = Eigen::VectorXd::Constant(layout_.all, 12.0 / std::pow(2.0 * std::numbers::pi, 2));
  for (const BoxedDirection& boxed : boxed_)
    beside[boxed.direction] = 12.0 / std::pow(boxed.upper - boxed.lower, 2);
  sum.diagonal() += beside;
  return sum;
}

Eigen::VectorXd PosteriorDensity::weights(const MotionEquations& equations) const {
  return equations.is_data.array() / dispersion_ + (1.0 - equations.is_data.array());
}

double PosteriorDensity::cost(const MotionEquations& equations) const {
  double sum = 0.0;
  for (Eigen::Index row = 0; row < equations.residual.size(); ++row) {
    const double r = equations.residual[row];
    sum += 0.5 * (equations.is_data[row] > 0.0 ? loss_value(problem_.loss, r).rho / dispersion_ : r * r);
  }
  return sum;
}

}  // namespace samara::identification
