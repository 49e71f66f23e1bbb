#include "samara/models/wind/wind_profile.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/wind/wind_spectrum.h"

namespace samara::models::wind {

namespace {

/// Below this share of the reference height the power law, whose slope has no bound, goes on as a straight line.
constexpr double kStraightShare = 1e-3;

class SurfaceLayer final : public TurbulentFlow {
 public:
  SurfaceLayer(const WindProfile& profile, double towards, EnergyConstants constants)
      : profile_(profile),
        along_(std::cos(towards), std::sin(towards), 0.0),
        top_(surface_layer_turbulence(profile.friction_velocity(), profile.options().roughness, constants)) {}

  AmbientSample sample(double, const Eigen::Vector3d& position) const override {
    AmbientSample here;
    here.velocity = profile_.speed(position.z()) * along_;
    here.gradient.col(2) = profile_.shear(position.z()) * along_;
    return here;
  }

  Turbulence turbulence(double, const Eigen::Vector3d& position) const override {
    const ProfileOptions& o = profile_.options();
    Turbulence here = top_;
    here.epsilon *= o.roughness / std::max(position.z() - o.displacement, o.roughness);
    return here;
  }

  double length() const override { return profile_.length(); }

 private:
  WindProfile profile_;
  Eigen::Vector3d along_;
  Turbulence top_;  ///< just above the roughness
};

}  // namespace

WindProfile::WindProfile(const ProfileOptions& options) : options_(options) {
  const ProfileOptions& o = options_;
  require_not_negative(o.speed, "the mean speed of the wind [m/s]");
  if (o.kind == ProfileKind::uniform) return;
  require_positive(o.height, "the height of the mean speed [m]");
  if (o.kind == ProfileKind::power) {
    require_positive(o.exponent, "the exponent of the wind profile");
    return;
  }
  require_positive(o.roughness, "the roughness of the ground [m]");
  require_not_negative(o.displacement, "the displacement of the wind profile [m]");
  if (o.height > o.displacement + o.roughness) return;
  throw ArgumentError(
      fmt::format("the height of the mean speed is {:.6g} m; more than {:.6g} m, displacement and roughness, "
                  "was expected",
                  o.height, o.displacement + o.roughness));
}

double WindProfile::speed(double z) const {
  const ProfileOptions& o = options_;
  switch (o.kind) {
    case ProfileKind::uniform:
      return o.speed;
    case ProfileKind::logarithmic: {
      const double above = z - o.displacement;
      if (above <= o.roughness) return 0.0;
      return o.speed * std::log(above / o.roughness) / std::log((o.height - o.displacement) / o.roughness);
    }
    case ProfileKind::power:
      break;
  }
  const double relative = z / o.height;
  if (relative > kStraightShare) return o.speed * std::pow(relative, o.exponent);
  return relative <= 0.0 ? 0.0 : shear(z) * z;
}

double WindProfile::shear(double z) const {
  const ProfileOptions& o = options_;
  switch (o.kind) {
    case ProfileKind::uniform:
      return 0.0;
    case ProfileKind::logarithmic: {
      const double above = z - o.displacement;
      return above >= o.roughness ? friction_velocity() / (kKarman * above) : 0.0;
    }
    case ProfileKind::power:
      break;
  }
  const double relative = z / o.height;
  if (relative > kStraightShare) return o.exponent * o.speed / z * std::pow(relative, o.exponent);
  return relative < 0.0 ? 0.0 : o.speed / o.height * std::pow(kStraightShare, o.exponent - 1.0);
}

double WindProfile::friction_velocity() const {
  if (options_.kind != ProfileKind::logarithmic)
    throw ArgumentError("only a logarithmic wind profile has a friction velocity");
  return kKarman * options_.speed / std::log((options_.height - options_.displacement) / options_.roughness);
}

double WindProfile::length() const {
  switch (options_.kind) {
    case ProfileKind::uniform:
      return 0.0;
    case ProfileKind::logarithmic:
      return 10.0 * options_.roughness;
    case ProfileKind::power:
      break;
  }
  return 10.0 * kStraightShare * options_.height;
}

Turbulence surface_layer_turbulence(double friction_velocity, double z, EnergyConstants constants) {
  require_positive(friction_velocity, "the friction velocity [m/s]");
  require_positive(z, "the height above the displacement [m]");
  constexpr double kCmu = 0.09;
  double ratio = 1.0 / std::sqrt(kCmu);
  if (constants == EnergyConstants::kaimal) {
    ratio = 0.5 * (kaimal_variance(Component::along) + kaimal_variance(Component::across) +
                   kaimal_variance(Component::vertical));
  }
  const double u2 = friction_velocity * friction_velocity;
  return {.k = ratio * u2, .epsilon = u2 * friction_velocity / (kKarman * z)};
}

std::shared_ptr<const TurbulentFlow> surface_layer(const WindProfile& profile, double towards,
                                                   EnergyConstants constants) {
  require(std::isfinite(towards), "the direction of the wind [rad]", towards, "a finite number");
  require_positive(profile.friction_velocity(), "the friction velocity [m/s]");
  return std::make_shared<SurfaceLayer>(profile, towards, constants);
}

}  // namespace samara::models::wind
