#include "samara/identification/fit/fill_result.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/identification/problem/camera.h"
#include "samara/identification/statistics/cluster_errors.h"

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
  for (const models::FamilyCoordinate& c : problem.own) nuisances.push_back({c.name, c.unit});
  for (const ComparedOutput& output : problem.outputs) {
    if (output.offset) nuisances.push_back({fmt::format("offset of {}", output.name), output.unit});
  }
  for (const std::string& name : camera_unknowns(problem))
    nuisances.push_back({name, name == kCameraScale ? "1" : "rad"});
  for (std::size_t k = 0; k < nuisances.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    nuisances[k].value = nuisances[k].name == kCameraScale ? 1.0 + own[at] : own[at];
    nuisances[k].at_bound = uncertainty.at_bound[k] != 0;
    if (!std::isnan(uncertainty.standard_error[at]))
      nuisances[k].standard_error = uncertainty.standard_error[at];
  }
  return nuisances;
}

/// Sum of squares of measured - model per output, SI, and their number.
struct Squares {
  Eigen::VectorXd sum, count;
  double turn_sum = 0.0, turn_count = 0.0;  ///< of the angle between attitudes

  explicit Squares(const FitProblem& problem)
      : sum(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.outputs.size()))), count(sum) {}

  void add(const FitProblem& problem, const SegmentResidual& residual) {
    const Segment& segment = residual.segment();
    for (std::size_t k = 0; k < segment.observations.size(); ++k) {
      const int o = segment.observations[k].output;
      const double difference = residual.residual()[static_cast<Eigen::Index>(k)] *
                                problem.outputs[static_cast<std::size_t>(o)].scale;
      sum[o] += difference * difference;
      count[o] += 1.0;
    }
    if (!problem.attitude_scale) return;
    const auto turns = static_cast<Eigen::Index>(segment.observations.size());
    const auto rows = static_cast<Eigen::Index>(3 * segment.attitudes.size());
    turn_sum += residual.residual().segment(turns, rows).squaredNorm() * std::pow(*problem.attitude_scale, 2);
    turn_count += static_cast<double>(segment.attitudes.size());
  }

  std::vector<OutputRms> rms(const FitProblem& problem) const {
    std::vector<OutputRms> result;
    for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
      const auto at = static_cast<Eigen::Index>(o);
      const double value =
          count[at] > 0.0 ? std::sqrt(sum[at] / count[at]) : std::numeric_limits<double>::quiet_NaN();
      result.push_back({problem.outputs[o].name, problem.outputs[o].unit, value});
    }
    if (turn_count > 0.0) result.push_back({"attitude", "rad", std::sqrt(turn_sum / turn_count)});
    return result;
  }
};

/// Frames of a motion in a row: times since the start of the capture, and per output what was measured and
/// what the model says.
void add_frames(const FitProblem& problem, const Motion& motion,
                const std::vector<SegmentResidual>& residuals, const FitPoint& point, CaptureFit& capture) {
  const auto outputs = static_cast<Eigen::Index>(problem.outputs.size());
  Eigen::Index frames = 0;
  for (std::size_t k = 0; k < motion.segment_count; ++k) {
    frames += residuals[motion.first_segment + k].values().rows();
  }
  capture.frames = static_cast<int>(frames);
  capture.times.resize(frames);
  capture.model.resize(frames, outputs);
  capture.measured.setConstant(frames, outputs, std::numeric_limits<double>::quiet_NaN());
  Eigen::Index first = 0;
  for (std::size_t k = motion.first_segment; k < motion.first_segment + motion.segment_count; ++k) {
    const Segment& segment = problem.segments[k];
    const auto values = residuals[k].values();
    for (Eigen::Index row = 0; row < values.rows(); ++row) {
      capture.times[first + row] = segment.start + segment.times[static_cast<std::size_t>(row)];
    }
    capture.model.middleRows(first, values.rows()) = residuals[k].seen(point.own[k].data());
    for (std::size_t row = 0; row < segment.observations.size(); ++row) {
      const Observation& o = segment.observations[row];
      capture.measured(first + o.frame, o.output) = o.value;
      // The turn of the circle on which the difference was taken.
      const double scale = problem.outputs[static_cast<std::size_t>(o.output)].scale;
      capture.model(first + o.frame, o.output) =
          o.value + scale * residuals[k].residual()[static_cast<Eigen::Index>(row)];
    }
    first += values.rows();
  }
}

/// @param camera of the problem, if it has one
CameraOptions resolved(const FitProblem& problem, const CameraOptions& options) {
  CameraOptions camera = options;
  if (!problem.camera) return camera;
  camera.axes.clear();
  for (const int column : problem.camera->columns)
    camera.axes.push_back(problem.requested[static_cast<std::size_t>(column)]);
  return camera;
}

}  // namespace

void add_setup(const models::FamilyInfo& family, const FitProblem& problem, const FitOptions& options,
               FitResult& result) {
  FitOptions& setup = result.setup;
  for (const ComparedOutput& output : problem.outputs) {
    setup.compared.outputs.push_back(output.name);
    setup.compared.periods[output.name] = output.period;
  }
  if (problem.attitude_scale)
    setup.compared.outputs.insert(setup.compared.outputs.end(), family.attitude.begin(),
                                  family.attitude.end());
  setup.compared.averaged_frames = problem.averaged_frames;
  setup.unknowns.fixed = options.unknowns.fixed;
  setup.unknowns.offsets = problem.offsets;
  setup.unknowns.shared = models::names_of(problem.shared);
  setup.unknowns.per_capture = models::names_of(problem.own);
  for (const std::string& name : problem.known) setup.unknowns.known.emplace(name, name);
  for (const auto* coordinates : {&problem.shared, &problem.own}) {
    for (const models::FamilyCoordinate& c : *coordinates) setup.unknowns.box[c.name] = {c.lower, c.upper};
  }
  for (const auto& [name, prior] : options.priors.coordinates) {
    if (models::position(problem.own, name)) setup.priors.coordinates[name] = prior;
  }
  setup.camera = resolved(problem, options.camera);
  setup.starts.round_body = options.starts.round_body;
}

void add_coefficients(const FitProblem& problem, const FitPoint& point, const Uncertainty& uncertainty,
                      FitResult& result) {
  for (std::size_t k = 0; k < problem.shared.size(); ++k) {
    const models::FamilyCoordinate& c = problem.shared[k];
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
    Coefficient& added = result.coefficients.back();
    if (!added.standard_error) continue;
    const Eigen::VectorXd shares = uncertainty.cluster_shares.row(at).transpose();
    added.cluster_shares = {shares.begin(), shares.end()};
    added.effective_clusters = effective_clusters(shares);
  }
  result.clusters = problem.cluster_count;
  result.cluster_names = problem.cluster_names;
  result.covariance = problem.cluster_count >= 2 ? uncertainty.clustered : uncertainty.naive;
  result.correlation = correlation_of(result.covariance);
  result.naive_covariance = uncertainty.naive;
}

void add_captures(const FitProblem& problem, const std::vector<SegmentResidual>& residuals,
                  const FitPoint& point, const Uncertainty& uncertainty, FitResult& result) {
  Squares all(problem);
  for (const Motion& motion : problem.motions) {
    const std::size_t first = motion.first_segment;
    Squares squares(problem);
    for (std::size_t k = first; k < first + motion.segment_count; ++k) {
      squares.add(problem, residuals[k]);
      all.add(problem, residuals[k]);
    }
    CaptureFit capture{.id = motion.id,
                       .file = motion.file,
                       .checksum = motion.checksum,
                       .whole = motion.whole,
                       .labels = motion.labels,
                       .notes = motion.notes,
                       .cluster = motion.cluster,
                       .segments = static_cast<int>(motion.segment_count),
                       .start = problem.segments[first].start,
                       .interval = problem.segments[first].interval,
                       .nuisances = nuisances_of(problem, point.own[first], uncertainty.own[first]),
                       .residuals = squares.rms(problem)};
    for (std::size_t k = 0; k < problem.known.size(); ++k) capture.known[problem.known[k]] = motion.known[k];
    add_frames(problem, motion, residuals, point, capture);
    result.captures.push_back(std::move(capture));
  }
  result.residuals = all.rms(problem);
  result.residual_count = problem.observation_count();
}

}  // namespace samara::identification
