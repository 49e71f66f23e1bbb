#include "samara/identification/solve/join_weights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

/// How far each direction may be off beforehand.
Eigen::VectorXd widest(const FitProblem& problem) {
  Eigen::VectorXd width = Eigen::VectorXd::Constant(problem.own_chart.directions(), std::numbers::pi);
  for (int k = 0; k < static_cast<int>(problem.own.size()); ++k) {
    if (problem.own_chart.is_part_of_quaternion(k)) continue;
    const models::FamilyCoordinate& c = problem.own[static_cast<std::size_t>(k)];
    width[problem.own_chart.direction_of(k)] = c.upper - c.lower;
  }
  for (const ComparedOutput& output : problem.outputs) {
    // An offset has no box; a thousand times the size of a large residual is as good as free.
    if (output.offset) {
      const int own = static_cast<int>(problem.own.size()) + *output.offset;
      width[problem.own_chart.direction_of(own)] = 1e3 * output.scale;
    }
  }
  const Eigen::Index first = width.size() - problem.camera_count();
  for (int k = 0; k < problem.camera_count(); ++k)
    width[first + k] = problem.camera->deviations[static_cast<std::size_t>(k)];
  return width;
}

}  // namespace

std::optional<Eigen::VectorXd> start_deviations(const FitProblem& problem,
                                                std::vector<SegmentResidual>& residuals,
                                                const FitPoint& point) {
  const Eigen::VectorXd prior = widest(problem).array().square().inverse();
  std::vector<Eigen::VectorXd> deviations;
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    SegmentResidual& residual = residuals[k];
    const double* next = residual.segment().joined ? point.own[k + 1].data() : nullptr;
    if (!residual.evaluate(point.shared.data(), point.own[k].data(), next, true)) return {};
    const Eigen::MatrixXd by_own = residual.by_own().topRows(residual.data_size()) *
                                   problem.own_chart.plus_jacobian(point.own[k].data());
    Eigen::MatrixXd information = by_own.transpose() * by_own;
    information.diagonal() += prior;
    const Eigen::MatrixXd covariance =
        information.ldlt().solve(Eigen::MatrixXd::Identity(information.rows(), information.cols()).eval());
    deviations.push_back(covariance.diagonal().cwiseSqrt());
  }
  Eigen::VectorXd by_direction(prior.size());
  for (Eigen::Index d = 0; d < by_direction.size(); ++d) {
    std::vector<double> values;
    for (const Eigen::VectorXd& one : deviations) values.push_back(one[d]);
    by_direction[d] = median(values);
  }
  Eigen::VectorXd by_join(problem.join_rows());
  Eigen::Index row = 0;
  for (const JoinRule& rule : problem.joins) {
    for (int part = 0; part < rule.rows(); ++part) {
      by_join[row++] = by_direction[problem.own_chart.direction_of(rule.own) + part];
    }
  }
  return by_join;
}

}  // namespace samara::identification
