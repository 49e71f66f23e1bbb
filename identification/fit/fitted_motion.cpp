#include "samara/identification/fit/fitted_motion.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/problem/camera.h"
#include "samara/models/trajectories/averaged_source.h"

namespace samara::identification {

namespace {

const Nuisance* find_nuisance(const CaptureFit& capture, const std::string& name) {
  const auto found = std::ranges::find(capture.nuisances, name, &Nuisance::name);
  return found == capture.nuisances.end() ? nullptr : &*found;
}

double value_of(const FitResult& fitted, const CaptureFit& capture, const std::string& name) {
  if (const Nuisance* own = find_nuisance(capture, name)) return own->value;
  const auto shared = std::ranges::find(fitted.coefficients, name, &Coefficient::name);
  if (shared != fitted.coefficients.end()) return shared->value;
  if (const auto held = fitted.fixed.find(name); held != fitted.fixed.end()) return held->second;
  const auto known = capture.known.find(name);
  if (known == capture.known.end()) {
    throw ArgumentError(fmt::format(
        "the fit says nothing of \"{}\"; the family and the options of the fit were expected", name));
  }
  return known->second;
}

/// Outputs asked for, and the axes of the camera beside them.
std::vector<std::string> with_axes(std::vector<std::string> outputs, const std::vector<std::string>& axes) {
  for (const std::string& axis : axes) {
    if (std::ranges::count(outputs, axis) == 0) outputs.push_back(axis);
  }
  return outputs;
}

/// Values as the capture's camera sees them.
/// @param values of `outputs`, times x outputs
void look_through_camera(const models::TrajectoryFamily& family, const FitOptions& options,
                         const CaptureFit& capture, const std::vector<std::string>& axes,
                         const std::vector<std::string>& outputs, Eigen::MatrixXd& values) {
  const auto column = [&](const std::string& name) {
    return static_cast<Eigen::Index>(std::ranges::find(outputs, name) - outputs.begin());
  };
  const Nuisance* scale = find_nuisance(capture, kCameraScale);
  std::vector<double> turn;
  for (const Nuisance& n : capture.nuisances) {
    if (n.name.starts_with(kCameraTurn)) turn.push_back(n.value);
  }
  const CameraView view(axes.size(), scale != nullptr ? scale->value - 1.0 : 0.0, turn);
  const auto count = static_cast<Eigen::Index>(axes.size());
  for (Eigen::Index row = 0; row < values.rows(); ++row) {
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (Eigen::Index k = 0; k < count; ++k)
      place[k] = values(row, column(axes[static_cast<std::size_t>(k)]));
    place = view.map * place;
    for (Eigen::Index k = 0; k < count; ++k)
      values(row, column(axes[static_cast<std::size_t>(k)])) = place[k];
  }
  for (const models::FamilyOutput& output : family.info().outputs) {
    const bool turns = options.camera.angles ? std::ranges::count(*options.camera.angles, output.name) > 0
                                             : output.unit == "rad";
    const Eigen::Index at = column(output.name);
    if (turns && at < values.cols()) values.col(at).array() += view.angle;
  }
  const std::vector<std::string>& attitude = family.info().attitude;
  const bool has_attitude =
      !attitude.empty() && turn.size() == 3 &&
      std::ranges::all_of(attitude, [&](const auto& part) { return column(part) < values.cols(); });
  if (!has_attitude) return;
  std::vector<Eigen::Index> parts;
  for (const std::string& part : attitude) parts.push_back(column(part));
  values(Eigen::all, parts) = (values(Eigen::all, parts) * view.on_attitude().transpose()).eval();
}

}  // namespace

std::optional<Eigen::MatrixXd> fitted_motion(const models::TrajectoryFamily& family,
                                             const FitOptions& options, const FitResult& fitted,
                                             std::size_t capture, const std::vector<double>& times,
                                             const std::vector<std::string>& outputs) {
  if (capture >= fitted.captures.size()) {
    throw ArgumentError(
        fmt::format("capture {} of a fit of {} was asked for; a number below that was expected", capture,
                    fitted.captures.size()));
  }
  const CaptureFit& one = fitted.captures[capture];
  std::vector<double> q;
  for (const models::FamilyCoordinate& c : family.info().coordinates)
    q.push_back(value_of(fitted, one, c.name));
  const bool has_camera = options.camera.scale || options.camera.rotation;
  const std::vector<std::string> axes =
      has_camera ? camera_axes(family.info(), options.camera) : std::vector<std::string>{};
  const std::vector<std::string> requested = with_axes(outputs, axes);
  const double delay = options.measurement.delay ? value_of(fitted, one, kDelay) : 0.0;
  std::vector<double> since_start;
  for (const double time : times) since_start.push_back(time - one.start + delay);
  const models::FrameMean mean{.frames = options.compared.averaged_frames, .interval = one.interval};
  Eigen::MatrixXd values(static_cast<Eigen::Index>(times.size()),
                         static_cast<Eigen::Index>(requested.size()));
  const auto source = averaged_source(family, mean, since_start, requested, {});
  if (!source->evaluate(q, values, nullptr) || !values.allFinite()) return {};
  if (has_camera) look_through_camera(family, options, one, axes, requested, values);
  values.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(outputs.size()));
  for (const auto& [output, range] : options.measurement.gains) {
    const auto column = std::ranges::find(outputs, output) - outputs.begin();
    if (column < std::ssize(outputs)) values.col(column) *= value_of(fitted, one, gain_name(output));
  }
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const Nuisance* offset = find_nuisance(one, fmt::format("offset of {}", outputs[o]));
    if (offset != nullptr) values.col(static_cast<Eigen::Index>(o)).array() += offset->value;
  }
  return values;
}

}  // namespace samara::identification
