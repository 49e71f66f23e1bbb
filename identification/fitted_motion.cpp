#include "samara/identification/fitted_motion.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/averaged_source.h"
#include "samara/io/text.h"

namespace samara::identification {

namespace {

const Nuisance* find_nuisance(const CaptureFit& capture, const std::string& name) {
  const auto found = std::ranges::find(capture.nuisances, name, &Nuisance::name);
  return found == capture.nuisances.end() ? nullptr : &*found;
}

double value_of(const FitOptions& options, const FitResult& fitted, const CaptureFit& capture,
                const std::string& name) {
  if (const Nuisance* own = find_nuisance(capture, name)) return own->value;
  const auto shared = std::ranges::find(fitted.coefficients, name, &Coefficient::name);
  if (shared != fitted.coefficients.end()) return shared->value;
  if (const auto held = fitted.fixed.find(name); held != fitted.fixed.end()) return held->second;
  const auto known = options.known.find(name);
  if (known == options.known.end() || !capture.labels.contains(known->second)) {
    throw ArgumentError(fmt::format(
        "the fit says nothing of \"{}\"; the family and the options of the fit were expected", name));
  }
  return io::read_number(capture.labels.at(known->second)).value;
}

}  // namespace

std::optional<Eigen::MatrixXd> fitted_motion(const TrajectoryFamily& family, const FitOptions& options,
                                             const FitResult& fitted, std::size_t capture,
                                             const std::vector<double>& times,
                                             const std::vector<std::string>& outputs) {
  if (capture >= fitted.captures.size()) {
    throw ArgumentError(
        fmt::format("capture {} of a fit of {} was asked for; a number below that was expected", capture,
                    fitted.captures.size()));
  }
  const CaptureFit& one = fitted.captures[capture];
  std::vector<double> q;
  for (const FitCoordinate& c : family.info().coordinates)
    q.push_back(value_of(options, fitted, one, c.name));
  std::vector<double> since_start;
  for (const double time : times) since_start.push_back(time - one.start);
  const FrameMean mean{.frames = options.averaged_frames, .interval = one.interval};
  Eigen::MatrixXd values(static_cast<Eigen::Index>(times.size()), static_cast<Eigen::Index>(outputs.size()));
  const auto source = averaged_source(family, mean, since_start, outputs, {});
  if (!source->evaluate(q, values, nullptr) || !values.allFinite()) return {};
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const Nuisance* offset = find_nuisance(one, fmt::format("offset of {}", outputs[o]));
    if (offset != nullptr) values.col(static_cast<Eigen::Index>(o)).array() += offset->value;
  }
  return values;
}

}  // namespace samara::identification
