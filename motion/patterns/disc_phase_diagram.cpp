#include "samara/motion/patterns/disc_phase_diagram.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/bodies/scaling_numbers.h"
#include "samara/motion/records/motion_record.h"

namespace samara::motion {

namespace {

Eigen::MatrixX2d rows(std::initializer_list<std::array<double, 2>> points) {
  Eigen::MatrixX2d all(static_cast<Eigen::Index>(points.size()), 2);
  Eigen::Index k = 0;
  for (const auto& [Re, I] : points) all.row(k++) << Re, I;
  return all;
}

/// Above this Reynolds number nothing is periodic at all inertias.
constexpr double kLeastChaoticRe = 155.0;

/// y at x on a line through points whose x increases, level beyond its ends.
double on_line(const Eigen::VectorXd& xs, const Eigen::VectorXd& ys, double x) {
  if (x <= xs[0]) return ys[0];
  for (Eigen::Index k = 1; k < xs.size(); ++k) {
    if (x <= xs[k]) return ys[k - 1] + (ys[k] - ys[k - 1]) * (x - xs[k - 1]) / (xs[k] - xs[k - 1]);
  }
  return ys[ys.size() - 1];
}

/// In logarithms.
Eigen::MatrixX2d logs(const RegimeBoundary& boundary) {
  return boundary.points.array().log();
}

Regime regime_at(double ln_Re, double ln_I) {
  const Eigen::MatrixX2d steady = logs(regime_boundaries()[0]), chaos = logs(regime_boundaries()[1]),
                         tumbling = logs(regime_boundaries()[2]);
  if (ln_Re < on_line(steady.col(1), steady.col(0), ln_I)) return Regime::steady;
  if (ln_Re < std::log(kLeastChaoticRe)) return Regime::periodic;
  if (ln_I > on_line(tumbling.col(0), tumbling.col(1), ln_Re)) return Regime::tumbling;
  return ln_I > on_line(chaos.col(0), chaos.col(1), ln_Re) ? Regime::chaotic : Regime::periodic;
}

Eigen::Vector2d nearest_on(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                           const Eigen::Vector2d& point) {
  const Eigen::Vector2d way = to - from;
  const double share = std::clamp((point - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
  return from + share * way;
}

/// The points of a boundary, its ends drawn on as on_line() does.
Eigen::MatrixX2d drawn_on(std::size_t number) {
  constexpr double kFar = 30.0;
  const Eigen::MatrixX2d line = logs(regime_boundaries()[number]);
  // That of tumbling begins with the wall of kLeastChaoticRe above it.
  constexpr std::array<Eigen::Index, 3> kBefore = {1, 0, 2};
  const Eigen::Index first = kBefore[number];
  Eigen::MatrixX2d all(first + line.rows() + 1, 2);
  all.topRows(first).rowwise() = line.row(0);
  all.middleRows(first, line.rows()) = line;
  all.bottomRows(1) = line.bottomRows(1);
  if (number == 0) {
    all(0, 1) -= kFar;
    all(all.rows() - 1, 1) += kFar;
    return all;
  }
  all(all.rows() - 1, 0) += kFar;
  if (number == 2) {
    all.col(0).head(first).setConstant(std::log(kLeastChaoticRe));
    all(0, 1) += kFar;
  }
  return all;
}

/// A parameter of the model by its name, if it has one.
std::optional<double> parameter(const models::Model& model, const std::vector<double>& values,
                                const char* name) {
  const auto& all = model.info().parameters;
  const auto it = std::ranges::find(all, name, &models::ParameterInfo::name);
  if (it == all.end() || it->unit == "1") return {};
  return values[static_cast<std::size_t>(it - all.begin())];
}

}  // namespace

std::string to_string(Regime regime) {
  switch (regime) {
    case Regime::steady:
      return "steady";
    case Regime::periodic:
      return "periodic";
    case Regime::chaotic:
      return "chaotic";
    case Regime::tumbling:
      return "tumbling";
  }
  throw ArgumentError("no such regime");
}

const std::vector<RegimeBoundary>& regime_boundaries() {
  static const std::vector<RegimeBoundary> boundaries = {
      {"end of steady descent", rows({{150.0, 2e-4},
                                      {160.0, 4.5e-4},
                                      {158.0, 8.6e-4},
                                      {128.0, 1.7e-3},
                                      {98.0, 3.4e-3},
                                      {89.0, 6e-3},
                                      {89.0, 1.2e-2},
                                      {99.0, 2e-2},
                                      {135.0, 5.2e-2}})},
      {"begin of chaos", rows({{155.0, 0.057},
                               {162.0, 0.026},
                               {200.0, 0.0183},
                               {285.0, 0.0129},
                               {430.0, 0.0101},
                               {740.0, 0.009},
                               {1400.0, 0.0083},
                               {2900.0, 0.0086},
                               {8900.0, 0.0097},
                               {27000.0, 0.0109}})},
      {"begin of tumbling", rows({{162.0, 0.0375}, {720.0, 0.0393}, {4600.0, 0.0408}, {34000.0, 0.0448}})}};
  return boundaries;
}

std::vector<RegimeBoundary> drawn_regime_boundaries() {
  std::vector<RegimeBoundary> lines = regime_boundaries();
  for (std::size_t k = 0; k < lines.size(); ++k) {
    lines[k].points = drawn_on(k).array().exp();
    auto Re = lines[k].points.col(0).array(), I = lines[k].points.col(1).array();
    Re = Re.max(kMeasuredDiscs.least_Re).min(kMeasuredDiscs.most_Re);
    I = I.max(kMeasuredDiscs.least_I).min(kMeasuredDiscs.most_I);
  }
  return lines;
}

RegimeAnswer regime(double Re, double I_disc) {
  require_positive(Re, "Re");
  require_positive(I_disc, "I_disc");
  const Eigen::Vector2d point(std::log(Re), std::log(I_disc));
  RegimeAnswer answer;
  answer.regime = regime_at(point.x(), point.y());
  answer.measured = Re >= kMeasuredDiscs.least_Re && Re <= kMeasuredDiscs.most_Re &&
                    I_disc >= kMeasuredDiscs.least_I && I_disc <= kMeasuredDiscs.most_I;
  answer.distance = std::numeric_limits<double>::infinity();
  for (std::size_t number = 0; number < regime_boundaries().size(); ++number) {
    const Eigen::MatrixX2d line = drawn_on(number);
    for (Eigen::Index k = 1; k < line.rows(); ++k) {
      if (line.row(k) == line.row(k - 1)) continue;
      const Eigen::Vector2d border = nearest_on(line.row(k - 1), line.row(k), point);
      const double distance = (border - point).norm();
      if (distance >= answer.distance) continue;
      // A step beyond it; where the same word stands there, it is no border of this regime.
      const Eigen::Vector2d step =
          distance > 0.0 ? Eigen::Vector2d((border - point) / distance) : Eigen::Vector2d(1, 0);
      const Eigen::Vector2d there = border + 1e-6 * step;
      const Regime beyond = regime_at(there.x(), there.y());
      if (beyond == answer.regime) continue;
      answer.distance = distance;
      answer.beyond = beyond;
    }
  }
  return answer;
}

FallNumbers fall_numbers(const models::Model& model, const std::vector<double>& parameters) {
  const auto value = [&](const char* name) { return parameter(model, parameters, name); };
  FallNumbers all;
  if (const auto a = value("a"), b = value("b"), c = value("c"); a && b && c) {
    all.thickness = 2.0 * std::min({*a, *b, *c});
  } else if (const auto half = value("semi_thickness"); half) {
    all.thickness = 2.0 * *half;
  } else if (const auto thickness = value("thickness"); thickness) {
    all.thickness = *thickness;
  }
  if (all.thickness > 0.0) all.length = MotionStates::body_length(model, parameters);
  const auto solid = value("density"), fluid = value("fluid_density"), g = value("g"), nu = value("nu");
  if (!(all.length > 0.0) || !solid || !fluid || !g || !nu) {
    throw ArgumentError(
        fmt::format("model \"{}\" does not say length, thickness, density, fluid_density, g and nu of a "
                    "falling body, expected one that does, such as immersed_body or falling_plate",
                    model.info().name));
  }
  all.solid_density = *solid;
  all.fluid_density = *fluid;
  all.gravity = *g;
  all.viscosity = *nu;
  all.speed = models::fall_speed_scale(*solid, *fluid, all.thickness, *g);
  require_positive(all.speed, "speed of fall of a body as dense as its fluid [m/s]");
  all.Re = models::fall_reynolds_number(*solid, *fluid, all.length, all.thickness, *nu, *g);
  all.I_disc = models::inertia_ratio_of_disc(*solid, *fluid, all.length, all.thickness);
  all.I_plate = models::inertia_ratio_of_plate(*solid, *fluid, all.length, all.thickness);
  all.I_ellipse = models::inertia_ratio_of_ellipse(*solid, *fluid, 0.5 * all.length, 0.5 * all.thickness);
  return all;
}

}  // namespace samara::motion
