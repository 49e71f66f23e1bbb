#include "samara/models/wind/gust.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "samara/base/require.h"

namespace samara::models::wind {

namespace {

using std::numbers::pi;

constexpr double kOperatingFactor = 0.37;

void check_finite(const Eigen::Vector3d& v, std::string_view what) {
  for (const double component : v) require(std::isfinite(component), what, component, "a finite number");
}

}  // namespace

Gust::Gust(const GustOptions& options) : options_(options), slowness_(Eigen::Vector3d::Zero()) {
  require_positive(options_.duration, "the duration of the gust [s]");
  require(std::isfinite(options_.start), "the start of the gust [s]", options_.start, "a finite number");
  check_finite(options_.velocity, "the velocity of the gust [m/s]");
  check_finite(options_.travel, "the velocity with which the gust travels [m/s]");
  if (!options_.travel.isZero(0.0)) slowness_ = options_.travel / options_.travel.squaredNorm();
  check_finite(slowness_, "the time that the gust takes for a metre [s/m]");
}

bool Gust::passes(double from, double to, const Eigen::Vector3d& position) const {
  const double arrival = options_.start + slowness_.dot(position);
  return to > arrival && from < arrival + options_.duration;
}

double Gust::course(double s) const {
  const double T = options_.duration;
  if (s <= 0.0) return 0.0;
  if (s >= T) return options_.shape == GustShape::step ? 1.0 : 0.0;
  switch (options_.shape) {
    case GustShape::one_minus_cosine:
      return 0.5 * (1.0 - std::cos(2.0 * pi * s / T));
    case GustShape::step:
      return 0.5 * (1.0 - std::cos(pi * s / T));
    case GustShape::extreme_operating:
      break;
  }
  return -kOperatingFactor * std::sin(3.0 * pi * s / T) * (1.0 - std::cos(2.0 * pi * s / T));
}

double Gust::course_rate(double s) const {
  const double T = options_.duration;
  if (s <= 0.0 || s >= T) return 0.0;
  switch (options_.shape) {
    case GustShape::one_minus_cosine:
      return pi / T * std::sin(2.0 * pi * s / T);
    case GustShape::step:
      return 0.5 * pi / T * std::sin(pi * s / T);
    case GustShape::extreme_operating:
      break;
  }
  return -kOperatingFactor * pi / T *
         (3.0 * std::cos(3.0 * pi * s / T) * (1.0 - std::cos(2.0 * pi * s / T)) +
          2.0 * std::sin(3.0 * pi * s / T) * std::sin(2.0 * pi * s / T));
}

AmbientSample Gust::sample(double t, const Eigen::Vector3d& position) const {
  const double s = t - options_.start - slowness_.dot(position);
  AmbientSample here;
  here.velocity = course(s) * options_.velocity;
  here.rate = course_rate(s) * options_.velocity;
  here.gradient = -here.rate * slowness_.transpose();
  return here;
}

double Gust::length() const {
  if (slowness_.isZero(0.0)) return std::numeric_limits<double>::infinity();
  return options_.duration / (2.0 * pi * slowness_.norm());
}

}  // namespace samara::models::wind
