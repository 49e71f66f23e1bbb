#include "samara/models/wind/wind.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"

namespace samara::models::wind {

namespace {

/// What of a wind is not random.
class MeanAndGusts {
 public:
  explicit MeanAndGusts(const Wind& wind)
      : profile_(wind.profile), along_(wind.direction()), gusts_(wind.gusts) {}

  AmbientSample sample(double t, const Eigen::Vector3d& position) const {
    AmbientSample here;
    here.velocity = profile_.speed(position.z()) * along_;
    here.gradient.col(2) = profile_.shear(position.z()) * along_;
    for (const Gust& gust : gusts_) add(gust.sample(t, position), here);
    return here;
  }

  double length() const {
    double least = profile_.length() > 0.0 ? profile_.length() : std::numeric_limits<double>::infinity();
    for (const Gust& gust : gusts_) least = std::min(least, gust.length());
    return least;
  }

  /// In which a gust that passes between two times changes [s]; infinite: none does.
  double time_scale(double from, double to, const Eigen::Vector3d& position) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Gust& gust : gusts_) {
      if (gust.passes(from, to, position)) least = std::min(least, gust.duration() / std::numbers::pi);
    }
    return least;
  }

  static void add(const AmbientSample& part, AmbientSample& sum) {
    sum.velocity += part.velocity;
    sum.gradient += part.gradient;
    sum.rate += part.rate;
  }

 private:
  WindProfile profile_;
  Eigen::Vector3d along_;
  std::vector<Gust> gusts_;
};

class WindFlow final : public AmbientFlow {
 public:
  WindFlow(MeanAndGusts mean_and_gusts, std::optional<WindModes> modes)
      : mean_and_gusts_(std::move(mean_and_gusts)), modes_(std::move(modes)) {}

  AmbientSample sample(double t, const Eigen::Vector3d& position) const override {
    AmbientSample here = mean_and_gusts_.sample(t, position);
    if (modes_) MeanAndGusts::add(modes_->sample(t, position), here);
    return here;
  }

  AmbientSample mean_over(const Ellipse& ellipse, double t, const Eigen::Vector3d& position) const {
    AmbientSample here = mean_and_gusts_.sample(t, position);
    if (modes_) MeanAndGusts::add(modes_->mean_over(ellipse, t, position), here);
    return here;
  }

  double time_scale(double from, double to, const Eigen::Vector3d& position) const {
    return mean_and_gusts_.time_scale(from, to, position);
  }

  double length() const override {
    const double least = std::min(mean_and_gusts_.length(),
                                  modes_ ? modes_->length() : std::numeric_limits<double>::infinity());
    return std::isfinite(least) ? least : 1.0;  // nothing changes over any way
  }

 private:
  MeanAndGusts mean_and_gusts_;
  std::optional<WindModes> modes_;
};

/// A body in one realisation: the field where it is, and as it is turned.
class AirInWind final : public AirAlongPath {
 public:
  AirInWind(WindFlow flow, const Eigen::Vector2d& semi_axes, const ModeSpectrum* modes)
      : flow_(std::move(flow)), semi_axes_(semi_axes) {
    if (!modes) return;
    convection_ = modes->options().convection;
    sweeping_ = modes->sweeping_speed();
    highest_ = modes->options().highest;
  }

  AirSeen start(const BodyOnPath& body) override {
    AirSeen air = seen(body, body.t, body.position);
    gradient_ = air.gradient;
    return air;
  }
  AirSeen step(const BodyOnPath& body, double h) override {
    // The wind is smooth: on the way to where it will be the body goes by the change of the air in the step before.
    AirSeen air = seen(body, body.t + h, body.position_after(h, h * rate_));
    rate_ = (air.velocity - body.air) / h;
    // That in the middle of the step, to second order.
    const Eigen::Matrix3d end = air.gradient;
    air.gradient = 0.5 * (gradient_ + end);
    gradient_ = end;
    return air;
  }

 private:
  AirSeen seen(const BodyOnPath& body, double t, const Eigen::Vector3d& position) const {
    AmbientSample here;
    if (semi_axes_.isZero(0.0)) {
      here = flow_.sample(t, position);
    } else {
      const Ellipse outline = {.first = semi_axes_[0] * body.attitude.col(0),
                               .second = semi_axes_[1] * body.attitude.col(1)};
      here = flow_.mean_over(outline, t, position);
    }
    AirSeen air{.velocity = here.velocity, .gradient = here.gradient};
    // In which half of the shortest wave passes the body: over a tenth of it a ramp is within 1 % of the wave.
    const double passing = std::hypot((body.velocity - convection_).norm(), sweeping_) * highest_;
    if (passing > 0.0) air.time_scale = std::numbers::pi / passing;
    air.time_scale = std::min(air.time_scale, flow_.time_scale(body.t, t, position));
    return air;
  }

  WindFlow flow_;
  Eigen::Vector2d semi_axes_;
  Eigen::Vector3d convection_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_ = Eigen::Vector3d::Zero();  ///< of the air along the path, in the step before [m/s^2]
  Eigen::Matrix3d gradient_ = Eigen::Matrix3d::Zero();  ///< where the next step begins [1/s]
  double sweeping_ = 0.0;
  double highest_ = 0.0;  ///< 0: there are no modes
};

class WindAir final : public AirSource {
 public:
  WindAir(MeanAndGusts mean_and_gusts, std::optional<ModeSpectrum> modes, const Eigen::Vector2d& semi_axes,
          std::uint64_t seed)
      : mean_and_gusts_(std::move(mean_and_gusts)),
        modes_(std::move(modes)),
        semi_axes_(semi_axes),
        seed_(seed) {}

  std::unique_ptr<AirAlongPath> realisation(std::uint64_t number, bool mirrored) const override {
    std::optional<WindModes> modes;
    if (modes_) modes.emplace(*modes_, seed_, number, mirrored);
    return std::make_unique<AirInWind>(WindFlow(mean_and_gusts_, std::move(modes)), semi_axes_,
                                       modes_ ? &*modes_ : nullptr);
  }

 private:
  MeanAndGusts mean_and_gusts_;
  std::optional<ModeSpectrum> modes_;
  Eigen::Vector2d semi_axes_;
  std::uint64_t seed_;
};

std::optional<ModeSpectrum> modes_of(const Wind& wind, double body_length) {
  if (!wind.turbulence) return {};
  return mode_spectrum(wind, body_length);
}

}  // namespace

Eigen::Vector3d Wind::direction() const {
  return {std::cos(towards), std::sin(towards), 0.0};
}

ModeSpectrum mode_spectrum(const Wind& wind, double body_length) {
  if (!wind.turbulence) throw ArgumentError("the wind has no turbulence; a wind with one was expected");
  const TurbulenceOptions& o = *wind.turbulence;
  const ProfileOptions& mean = wind.profile.options();
  const double height = o.height.value_or(mean.height);
  require_positive(height, "the height of the turbulence [m]");
  std::optional<double> sigma = o.sigma, length = o.length;
  if (!sigma || !length) {
    if (mean.kind != ProfileKind::logarithmic || !(mean.speed > 0.0)) {
      throw ArgumentError(
          "the turbulence has no sigma or no length, and they follow from the mean wind of a logarithmic "
          "profile only; "
          "both were expected");
    }
    const Turbulence layer =
        surface_layer_turbulence(wind.profile.friction_velocity(), height - mean.displacement, o.constants);
    const VonKarmanSpectrum of_layer = VonKarmanSpectrum::of_energy(layer.k, layer.epsilon);
    if (!sigma) sigma = of_layer.sigma();
    if (!length) length = of_layer.length();
  }
  const double shortest = o.shortest.value_or(body_length);
  require_positive(shortest, "the shortest wave of the turbulence [m]");
  if (o.longest) require_positive(*o.longest, "the longest wave of the turbulence [m]");
  const double longest = o.longest.value_or(2.0 * std::numbers::pi * *length / 0.02);
  if (!(longest > shortest)) {
    throw ArgumentError(fmt::format(
        "the longest wave of the turbulence is {:.6g} m{}, expected more than the shortest, {:.6g} m{}",
        longest, o.longest ? "" : ", that of its length", shortest,
        o.shortest ? "" : ": the length of the body"));
  }
  for (const double ratio : o.ratios) require_not_negative(ratio, "the ratio of a deviation to sigma");
  const Eigen::Matrix3d axes = Eigen::AngleAxisd(wind.towards, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return {VonKarmanSpectrum(*sigma, *length),
          {.modes = o.modes,
           .lowest = o.longest ? 2.0 * std::numbers::pi / *o.longest : 0.0,
           .highest = 2.0 * std::numbers::pi / shortest,
           .frozen = o.frozen,
           .convection = wind.profile.speed(height) * wind.direction(),
           .stretch = axes * o.ratios.asDiagonal() * axes.transpose()}};
}

std::shared_ptr<const AmbientFlow> wind_flow(const Wind& wind, double body_length, std::uint64_t seed,
                                             std::uint64_t realisation) {
  std::optional<WindModes> modes;
  if (const auto spectrum = modes_of(wind, body_length)) modes.emplace(*spectrum, seed, realisation);
  return std::make_shared<WindFlow>(MeanAndGusts(wind), std::move(modes));
}

std::shared_ptr<const AirSource> wind_air(const Wind& wind, double body_length,
                                          const Eigen::Vector2d& semi_axes, std::uint64_t seed) {
  for (const double axis : semi_axes) require_not_negative(axis, "a semi-axis of the body [m]");
  return std::make_shared<WindAir>(MeanAndGusts(wind), modes_of(wind, body_length), semi_axes, seed);
}

}  // namespace samara::models::wind
