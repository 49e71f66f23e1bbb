#include "samara/identification/fit_summary.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace samara::identification {

namespace {

std::optional<double> standard_error(const Eigen::MatrixXd& covariance, Eigen::Index k) {
  const double variance = covariance(k, k);
  if (std::isnan(variance)) return {};
  return std::sqrt(variance);
}

Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd inverse = covariance.diagonal().cwiseSqrt().cwiseInverse();
  return inverse.asDiagonal() * covariance * inverse.asDiagonal();
}

std::vector<Nuisance> nuisances_of(const FitProblem& problem, const Eigen::VectorXd& own,
                                   const OwnUncertainty& uncertainty) {
  std::vector<Nuisance> nuisances;
  for (const FitCoordinate& c : problem.own) nuisances.push_back({c.name, c.unit});
  for (const ComparedOutput& output : problem.outputs) {
    if (output.offset) nuisances.push_back({fmt::format("offset of {}", output.name), output.unit});
  }
  for (std::size_t k = 0; k < nuisances.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    nuisances[k].value = own[at];
    nuisances[k].at_bound = uncertainty.at_bound[k] != 0;
    if (!std::isnan(uncertainty.standard_error[at]))
      nuisances[k].standard_error = uncertainty.standard_error[at];
  }
  return nuisances;
}

/// Sum of squares of measured - model per output, SI, and their number.
struct Squares {
  Eigen::VectorXd sum, count;

  explicit Squares(const FitProblem& problem)
      : sum(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.outputs.size()))), count(sum) {}

  void add(const FitProblem& problem, const SegmentResidual& residual) {
    for (Eigen::Index row = 0; row < residual.size(); ++row) {
      const int o = residual.segment().observations[static_cast<std::size_t>(row)].output;
      const double difference = residual.residual()[row] * problem.outputs[static_cast<std::size_t>(o)].scale;
      sum[o] += difference * difference;
      count[o] += 1.0;
    }
  }

  std::vector<OutputRms> rms(const FitProblem& problem) const {
    std::vector<OutputRms> result;
    for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
      const auto at = static_cast<Eigen::Index>(o);
      const double value =
          count[at] > 0.0 ? std::sqrt(sum[at] / count[at]) : std::numeric_limits<double>::quiet_NaN();
      result.push_back({problem.outputs[o].name, problem.outputs[o].unit, value});
    }
    return result;
  }
};

Eigen::MatrixXd measured_values(const FitProblem& problem, const Segment& segment) {
  Eigen::MatrixXd measured = Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(segment.times.size()),
                                                       static_cast<Eigen::Index>(problem.outputs.size()),
                                                       std::numeric_limits<double>::quiet_NaN());
  for (const Observation& o : segment.observations) measured(o.frame, o.output) = o.value;
  return measured;
}

Eigen::MatrixXd model_values(const FitProblem& problem, const SegmentResidual& residual,
                             const Eigen::VectorXd& own) {
  Eigen::MatrixXd model = residual.values();
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    const auto& offset = problem.outputs[o].offset;
    if (offset)
      model.col(static_cast<Eigen::Index>(o)).array() +=
          own[static_cast<Eigen::Index>(problem.own.size()) + *offset];
  }
  return model;
}

}  // namespace

void add_coefficients(const FitProblem& problem, const FitPoint& point, const Uncertainty& uncertainty,
                      FitResult& result) {
  for (std::size_t k = 0; k < problem.shared.size(); ++k) {
    const FitCoordinate& c = problem.shared[k];
    const auto at = static_cast<Eigen::Index>(k);
    result.coefficients.push_back({.name = c.name,
                                   .unit = c.unit,
                                   .value = point.shared[at],
                                   .lower = c.lower,
                                   .upper = c.upper,
                                   .standard_error = standard_error(uncertainty.clustered, at),
                                   .naive_standard_error = standard_error(uncertainty.naive, at),
                                   .at_bound = uncertainty.at_bound[k] != 0,
                                   .determined = uncertainty.determined[k] != 0});
  }
  result.clusters = problem.cluster_count;
  result.covariance = problem.cluster_count >= 2 ? uncertainty.clustered : uncertainty.naive;
  result.correlation = correlation_of(result.covariance);
}

void add_captures(const FitProblem& problem, const std::vector<SegmentResidual>& residuals,
                  const FitPoint& point, const Uncertainty& uncertainty, FitResult& result) {
  Squares all(problem);
  for (std::size_t c = 0; c < residuals.size(); ++c) {
    const Segment& segment = problem.segments[c];
    Squares squares(problem);
    squares.add(problem, residuals[c]);
    all.add(problem, residuals[c]);
    result.captures.push_back({.id = segment.id,
                               .file = segment.file,
                               .labels = segment.labels,
                               .cluster = segment.cluster,
                               .frames = static_cast<int>(segment.times.size()),
                               .nuisances = nuisances_of(problem, point.own[c], uncertainty.own[c]),
                               .residuals = squares.rms(problem),
                               .times = Eigen::Map<const Eigen::VectorXd>(
                                   segment.times.data(), static_cast<Eigen::Index>(segment.times.size())),
                               .measured = measured_values(problem, segment),
                               .model = model_values(problem, residuals[c], point.own[c])});
  }
  result.residuals = all.rms(problem);
  result.residual_count = problem.observation_count();
}

}  // namespace samara::identification
