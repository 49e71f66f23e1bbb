#include "samara/identification/problem/camera.h"

#include <algorithm>
#include <cmath>

#include <ceres/jet.h>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/captures/capture.h"

namespace samara::identification {

namespace {

using TurnJet = ceres::Jet<double, 3>;

/// Functions of the square of an angle that have no singularity at 0.
struct TurnFunctions {
  TurnJet cosine, sine, versine;  ///< cos(a/2), sin(a/2)/a, and (1 - cos a)/a^2 = 2 (sin(a/2)/a)^2

  explicit TurnFunctions(const TurnJet& square) {
    if (square.a < 1e-4) {  // the next terms are below rounding
      cosine = 1.0 - square / 8.0 + square * square / 384.0 - square * square * square / 46080.0;
      sine = 0.5 - square / 48.0 + square * square / 3840.0 - square * square * square / 645120.0;
    } else {
      const TurnJet angle = sqrt(square);
      cosine = cos(0.5 * angle);
      sine = sin(0.5 * angle) / angle;
    }
    versine = 2.0 * sine * sine;
  }
};

/// Of a rotation vector, with derivatives.
void turn_in_space(std::span<const double> turn, CameraView& view, Eigen::Matrix3d& rotation) {
  std::array<TurnJet, 3> r;
  for (int k = 0; k < 3; ++k) r[static_cast<std::size_t>(k)] = TurnJet(turn[static_cast<std::size_t>(k)], k);
  const TurnJet square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
  const TurnFunctions f(square);
  const TurnJet whole = 2.0 * f.sine * f.cosine;  // sin(a)/a
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      // 1 + sin(a)/a [r] + (1 - cos a)/a^2 (r r^T - a^2)
      TurnJet entry = f.versine * r[static_cast<std::size_t>(i)] * r[static_cast<std::size_t>(k)];
      if (i == k) {
        entry += 1.0 - f.versine * square;
      } else {
        const int third = 3 - i - k;
        const double sign = (k - i + 3) % 3 == 1 ? -1.0 : 1.0;
        entry += sign * whole * r[static_cast<std::size_t>(third)];
      }
      rotation(i, k) = entry.a;
      for (int by = 0; by < 3; ++by) view.by_turn[static_cast<std::size_t>(by)](i, k) = entry.v[by];
    }
  }
  view.turn[0] = f.cosine.a;
  view.turn_by_turn.row(0) = f.cosine.v.transpose();
  for (int k = 0; k < 3; ++k) {
    const TurnJet part = f.sine * r[static_cast<std::size_t>(k)];
    view.turn[k + 1] = part.a;
    view.turn_by_turn.row(k + 1) = part.v.transpose();
  }
}

void turn_in_plane(double angle, CameraView& view, Eigen::Matrix3d& rotation) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  rotation.topLeftCorner<2, 2>() << c, -s, s, c;
  view.by_turn[0].topLeftCorner<2, 2>() << -s, -c, c, -s;
  view.angle = angle;
}

/// The unknowns of the turn, if there are any.
std::span<const double> turn_of(const Camera& camera, const double* own) {
  if (!camera.turn) return {};
  return {own + *camera.turn, static_cast<std::size_t>(camera.turns())};
}

/// @throws ArgumentError for a name that stands in the list twice.
void check_once(const std::string& field, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (std::ranges::count(names, name) == 1) continue;
    throw ArgumentError(
        fmt::format("{}: \"{}\" stands there twice; different outputs were expected", field, name));
  }
}

const std::string& unit_of(const models::FamilyInfo& family, const std::string& output) {
  return std::ranges::find(family.outputs, output, &models::FamilyOutput::name)->unit;
}

/// Axes are lengths in one unit, or numbers where the model has no units.
void check_places(const models::FamilyInfo& family, const std::vector<std::string>& axes) {
  for (const std::string& axis : axes) {
    const std::string& unit = unit_of(family, axis);
    const bool is_place = unit == "m" || unit == "1";
    if (is_place && unit == unit_of(family, axes.front()) && !is_angle({axis, unit, {}})) continue;
    throw ArgumentError(fmt::format(
        "camera.axes: \"{}\" is in {}; coordinates of the place, all in m or all without a unit, were "
        "expected",
        axis, unit));
  }
}

/// Compared outputs that turn with two axes.
std::vector<int> turning_angles(const CameraOptions& options, const std::vector<std::string>& axes,
                                const FitProblem& problem) {
  check_once("camera.angles", options.angles.value_or(std::vector<std::string>{}));
  std::vector<int> angles;
  std::vector<std::string> known;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    const ComparedOutput& output = problem.outputs[o];
    known.push_back(output.name);
    const bool turns =
        options.angles ? std::ranges::count(*options.angles, output.name) > 0 : output.unit == "rad";
    if (!turns) continue;
    const bool is_angle = output.unit == "rad" || output.unit == "1";
    if (!is_angle || std::ranges::count(axes, output.name) > 0) {
      throw ArgumentError(
          fmt::format("camera.angles: \"{}\" is {}; an angle, in rad or without a unit, was expected",
                      output.name, is_angle ? "one of camera.axes" : fmt::format("in {}", output.unit)));
    }
    angles.push_back(static_cast<int>(o));
  }
  for (const std::string& name : options.angles.value_or(std::vector<std::string>{})) {
    if (std::ranges::count(known, name) > 0) continue;
    throw ArgumentError(fmt::format("camera.angles: \"{}\" is not among the compared outputs{}", name,
                                    suggestion(name, known)));
  }
  return angles;
}

}  // namespace

CameraView::CameraView(std::size_t axes, double scale_error, std::span<const double> turn_by) {
  by_turn.fill(Eigen::Matrix3d::Zero());
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  if (!turn_by.empty() && axes == 3) turn_in_space(turn_by, *this, rotation);
  if (!turn_by.empty() && axes == 2) turn_in_plane(turn_by[0], *this, rotation);
  by_scale = rotation;
  map = (1.0 + scale_error) * rotation;
  for (Eigen::Matrix3d& derivative : by_turn) derivative *= 1.0 + scale_error;
}

CameraView::CameraView(const Camera& camera, const double* own)
    : CameraView(camera.columns.size(), camera.scale ? own[*camera.scale] : 0.0, turn_of(camera, own)) {}

Eigen::Matrix4d CameraView::on_attitude() const {
  const Eigen::Vector4d& r = turn;
  Eigen::Matrix4d matrix;
  matrix << r[0], -r[1], -r[2], -r[3],  //
      r[1], r[0], -r[3], r[2],          //
      r[2], r[3], r[0], -r[1],          //
      r[3], -r[2], r[1], r[0];
  return matrix;
}

Eigen::Matrix4d CameraView::on_turn(const Eigen::Vector4d& attitude) {
  const Eigen::Vector4d& q = attitude;
  Eigen::Matrix4d matrix;
  matrix << q[0], -q[1], -q[2], -q[3],  //
      q[1], q[0], q[3], -q[2],          //
      q[2], -q[3], q[0], q[1],          //
      q[3], q[2], -q[1], q[0];
  return matrix;
}

std::vector<std::string> camera_axes(const models::FamilyInfo& family, const CameraOptions& options) {
  const std::vector<std::string> axes = options.axes.empty() ? family.translations : options.axes;
  const std::vector<std::string> known = output_names(family);
  for (const std::string& axis : axes) {
    if (std::ranges::count(known, axis) > 0) continue;
    throw ArgumentError(fmt::format("camera.axes: \"{}\" is no output of \"{}\"{}", axis, family.model,
                                    suggestion(axis, known)));
  }
  const std::size_t least = options.rotation ? 2 : 1;
  if (axes.size() < least || axes.size() > 3) {
    throw ArgumentError(fmt::format(
        "camera.axes: there are {} ({}); {} outputs that are coordinates of the place were expected",
        axes.size(), axes.empty() ? "none" : join(axes), options.rotation ? "2 or 3" : "1 to 3"));
  }
  check_once("camera.axes", axes);
  check_places(family, axes);
  return axes;
}

void add_camera(const models::FamilyInfo& family, const FitOptions& options, FitProblem& problem) {
  const CameraOptions& wanted = options.camera;
  if (!wanted.scale && !wanted.rotation) {
    if (wanted.axes.empty() && !wanted.angles) return;
    throw ArgumentError("camera: neither scale nor rotation is given; one of them, or both, was expected");
  }
  const std::vector<std::string> axes = camera_axes(family, wanted);
  const bool any = std::ranges::any_of(axes, [&](const std::string& axis) {
    return std::ranges::count(problem.outputs, axis, &ComparedOutput::name) > 0;
  });
  if (!any) throw ArgumentError(fmt::format("camera: none of its axes ({}) is compared", join(axes)));
  Camera camera;
  for (const std::string& axis : axes) {
    const auto found = std::ranges::find(problem.requested, axis);
    camera.columns.push_back(static_cast<int>(found - problem.requested.begin()));
    if (found == problem.requested.end()) problem.requested.push_back(axis);
  }
  for (const std::string& axis : axes) {
    const std::string start = axis + "(0)";
    const bool is_own = std::ranges::count(problem.own, start, &models::FamilyCoordinate::name) > 0;
    const auto held = problem.fixed.find(start);
    camera.is_own.push_back(is_own ? 1 : 0);
    const std::optional<std::size_t> slot = position(family.coordinates, start);
    camera.start_slots.push_back(slot ? static_cast<int>(*slot) : JoinRule::kNone);
    camera.starts.push_back(held == problem.fixed.end() ? 0.0 : held->second);
  }
  const std::vector<int> angles = turning_angles(wanted, axes, problem);
  int next = problem.own_count();
  const auto add = [&](double deviation) {
    camera.deviations.push_back(deviation);
    problem.own_priors.emplace_back(next, Prior{.mean = 0.0, .deviation = deviation});
    return next++;
  };
  if (wanted.scale) camera.scale = add(*wanted.scale);
  if (wanted.rotation) {
    if (axes.size() == 2) camera.angles = angles;
    camera.turn = add(*wanted.rotation);
    for (int k = 1; k < camera.turns(); ++k) add(*wanted.rotation);
  }
  problem.camera = std::move(camera);
}

std::vector<std::string> camera_unknowns(const FitProblem& problem) {
  std::vector<std::string> names;
  if (!problem.camera) return names;
  const Camera& camera = *problem.camera;
  if (camera.scale) names.emplace_back(kCameraScale);
  if (camera.turns() == 1) names.emplace_back(kCameraTurn);
  for (int k = 0; camera.turns() == 3 && k < 3; ++k) {
    const int column = camera.columns[static_cast<std::size_t>(k)];
    names.push_back(
        fmt::format("{} about {}", kCameraTurn, problem.requested[static_cast<std::size_t>(column)]));
  }
  return names;
}

}  // namespace samara::identification
