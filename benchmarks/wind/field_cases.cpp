#include <array>
#include <cmath>
#include <map>
#include <vector>

#include <Eigen/Geometry>

#include "cases.h"
#include "samara/base/errors.h"
#include "samara/base/streams.h"
#include "samara/models/laws/registry.h"
#include "samara/models/stochastic/realisations.h"
#include "samara/models/wind/wind.h"

namespace samara::benchmarks {

namespace {

using namespace models::wind;

constexpr double kSigma = 1.2, kLength = 10.0;

ModeSpectrum band_of_200() {
  return {VonKarmanSpectrum(kSigma, kLength), {.lowest = 0.02 / kLength, .highest = 200.0 / kLength}};
}

/// The sum as one writes it first: mode by mode, with the functions of the library.
struct PlainModes {
  struct Mode {
    Eigen::Vector3d k, a, b;
    double frequency;
  };
  std::vector<Mode> modes;

  PlainModes() {
    Stream random(1, 0);
    const ModeSpectrum spectrum = band_of_200();
    for (int m = 0; m < 200; ++m) {
      const ModeSpectrum::Stratum stratum = spectrum.at_share((m + 0.5) / 200.0);
      const auto vector = [&] { return Eigen::Vector3d(random.normal(), random.normal(), random.normal()); };
      const Eigen::Vector3d direction = vector().normalized();
      modes.push_back({stratum.wave_number * direction, std::sqrt(stratum.energy) * direction.cross(vector()),
                       std::sqrt(stratum.energy) * direction.cross(vector()),
                       0.4 * kSigma * stratum.wave_number});
    }
  }

  models::AmbientSample sample(double t, const Eigen::Vector3d& place) const {
    models::AmbientSample sum;
    for (const Mode& mode : modes) {
      const double phase = mode.k.dot(place) + mode.frequency * t;
      const double c = std::cos(phase), s = std::sin(phase);
      sum.velocity += c * mode.a + s * mode.b;
      const Eigen::Vector3d slope = c * mode.b - s * mode.a;
      sum.gradient += slope * mode.k.transpose();
      sum.rate += mode.frequency * slope;
    }
    return sum;
  }
};

}  // namespace

void modes_case(const Options& options) {
  const int realisations = options.quick ? 600 : 20000;
  constexpr int kPlaces = 8;
  constexpr std::array kWays = {0.03, 0.1, 0.3, 1.0, 3.0};
  const ModeSpectrum spectrum = band_of_200();
  std::array<double, kWays.size()> structure = {};
  double variance = 0.0, divergence = 0.0;
  for (int r = 0; r < realisations; ++r) {
    const WindModes wind(spectrum, 1, static_cast<std::uint64_t>(r));
    Stream random(2, static_cast<std::uint64_t>(r));
    const auto anywhere = [&](double size) -> Eigen::Vector3d {
      return size * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    };
    for (int i = 0; i < kPlaces; ++i) {
      const Eigen::Vector3d here = anywhere(100.0 * kLength), way = anywhere(1.0).normalized();
      const models::AmbientSample at = wind.sample(0.0, here);
      variance += at.velocity.squaredNorm() / (3.0 * kPlaces * realisations);
      divergence = std::max(divergence, std::abs(at.gradient.trace()) / at.gradient.norm());
      for (std::size_t k = 0; k < kWays.size(); ++k) {
        const double change =
            way.dot(wind.sample(0.0, here + kWays[k] * kLength * way).velocity - at.velocity);
        structure[k] += change * change / (kPlaces * realisations);
      }
    }
  }
  double structure_error = 0.0;
  for (std::size_t k = 0; k < kWays.size(); ++k) {
    const double exact = spectrum.spectrum().structure_function(kWays[k] * kLength, spectrum.options().lowest,
                                                                spectrum.options().highest);
    structure_error = std::max(structure_error, std::abs(structure[k] / exact - 1.0));
  }
  const auto show = [](const char* metric, double value) {
    print({.bench = "wind",
           .test_case = "modes_200",
           .metric = metric,
           .value = value,
           .baseline = "exact band"});
  };
  show("D_LL_error", structure_error);
  show("divergence", divergence);
  show("variance_error", std::abs(variance / (kSigma * kSigma * spectrum.variance_share()) - 1.0));
}

void point_case(const Options& options) {
  const WindModes wind(band_of_200(), 1, 0);
  const PlainModes plain;
  const Ellipse leaf = {.first = {0.04, 0.0, 0.0}, .second = {0.0, 0.02, 0.0}};
  constexpr int kPlaces = 1000;
  double sum = 0.0;
  const auto over_places = [&](const auto& at) {
    return [&sum, at] {
      for (int i = 0; i < kPlaces; ++i) sum += at(Eigen::Vector3d(0.013 * i, 2.0, 1.0)).velocity.x();
    };
  };
  const int rounds = options.quick ? 5 : 25;
  const auto show = [&](const char* metric, const auto& at) {
    const Pair times = time_both(
        over_places(at), over_places([&](const auto& place) { return plain.sample(0.3, place); }), rounds);
    print({.bench = "wind",
           .test_case = "point",
           .metric = metric,
           .value = times.ours / kPlaces,
           .unit = "s",
           .baseline = "loop with std::sin, std::cos",
           .ratio = times.ratio()});
  };
  show("time", [&](const Eigen::Vector3d& place) { return wind.sample(0.3, place); });
  show("time_over_outline", [&](const Eigen::Vector3d& place) { return wind.mean_over(leaf, 0.3, place); });
  if (!std::isfinite(sum)) throw NoResultError("the sum of velocities is not finite");
}

void meadow_case(const Options& options) {
  Wind wind{.profile = WindProfile({.speed = 4.0, .height = 10.0, .roughness = 0.03})};
  wind.turbulence = TurbulenceOptions{.height = 2.0};
  const std::map<std::string, double> leaf = {
      {"a", 0.035},   {"b", 0.02},   {"c", 1e-4},   {"density", 700.0}, {"C_D90", 1.81},
      {"C_D0", 0.05}, {"C_T", 0.31}, {"C_R", 0.31}, {"C_w", 2.0},       {"z(0)", 2.0}};
  const models::ParametricModel model(models::find_model("immersed_body_in_gusts"), leaf, {});
  const auto air = wind_air(wind, 0.07, {0.035, 0.02}, 1);
  const std::vector<double> times = {0.0, 1.0, 2.0, 3.0, 4.0};
  const long realisations = options.quick ? 100 : 1000;
  const auto call = [&] {
    models::realise(model, {}, *air, times, {.realisations = realisations, .ground = 0.0});
  };
  print({.bench = "wind",
         .test_case = "meadow_1000",
         .metric = "time",
         .value = time_of(call, 1, 0.0) * (1000.0 / static_cast<double>(realisations)),
         .unit = "s"});
}

}  // namespace samara::benchmarks
