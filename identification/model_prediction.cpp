#include "samara/identification/model_prediction.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/averaged_source.h"
#include "samara/io/text.h"

namespace samara::identification {

namespace {

/// The coordinates of the family as the fit left them.
std::vector<double> coordinates_of(const TrajectoryFamily& family, const FitOptions& options,
                                   const FitResult& result, const CaptureFit& capture) {
  std::vector<double> q;
  for (const FitCoordinate& coordinate : family.info().coordinates) {
    const auto shared = std::ranges::find(result.coefficients, coordinate.name, &Coefficient::name);
    const auto own = std::ranges::find(capture.nuisances, coordinate.name, &Nuisance::name);
    const auto known = options.known.find(coordinate.name);
    if (shared != result.coefficients.end()) {
      q.push_back(shared->value);
    } else if (own != capture.nuisances.end()) {
      q.push_back(own->value);
    } else if (known != options.known.end()) {
      q.push_back(io::read_number(capture.labels.at(known->second)).value);
    } else {
      q.push_back(result.fixed.at(coordinate.name));
    }
  }
  return q;
}

}  // namespace

Eigen::MatrixXd predict(const TrajectoryFamily& family, const FitOptions& options, const FitResult& result,
                        std::size_t capture, const Eigen::VectorXd& times, double interval) {
  if (capture >= result.captures.size()) {
    throw ArgumentError(fmt::format("there is no capture {} to predict; a number less than {} was expected",
                                    capture, result.captures.size()));
  }
  const CaptureFit& seen = result.captures[capture];
  if (seen.segments != 1) {
    throw ArgumentError(fmt::format("capture \"{}\" has {} segments; one was expected for a prediction",
                                    seen.id, seen.segments));
  }
  FitProblem problem;
  problem.averaged_frames = options.averaged_frames;
  for (const OutputRms& output : result.residuals) {
    if (std::ranges::count(family.info().outputs, output.output, &FitOutput::name) > 0)
      problem.requested.push_back(output.output);
  }
  problem.slots.resize(family.info().coordinates.size());
  Segment segment;
  segment.interval = interval;
  for (const double time : times) segment.times.push_back(time - seen.start);

  Eigen::MatrixXd values(times.size(), static_cast<Eigen::Index>(problem.requested.size()));
  const std::vector<double> q = coordinates_of(family, options, result, seen);
  if (!averaged_source(family, problem, segment, {})->evaluate(q, values, nullptr)) {
    values.setConstant(std::numeric_limits<double>::quiet_NaN());
    return values;
  }
  for (std::size_t o = 0; o < problem.requested.size(); ++o) {
    const auto offset =
        std::ranges::find(seen.nuisances, fmt::format("offset of {}", problem.requested[o]), &Nuisance::name);
    if (offset != seen.nuisances.end()) values.col(static_cast<Eigen::Index>(o)).array() += offset->value;
  }
  return values;
}

}  // namespace samara::identification
