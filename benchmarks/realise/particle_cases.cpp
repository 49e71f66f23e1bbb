#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "cases.h"
#include "samara/base/streams.h"
#include "samara/models/stochastic/fluid_particles.h"

namespace samara::benchmarks {

namespace {

using models::Turbulence;

constexpr double kC0 = 6.0;

double dissipation(double k, double T) {
  return 4.0 * k / (3.0 * kC0 * T);
}

constexpr double kWaveTime = 0.1;  // T [s]

double wave_sigma(double z) {
  return 1.0 + 0.8 * std::cos(2.0 * std::numbers::pi * z);
}

Turbulence wave(double, const Eigen::Vector3d& x) {
  const double sigma = wave_sigma(x.z()), k = 1.5 * sigma * sigma;
  return {.k = k,
          .epsilon = dissipation(k, kWaveTime),
          .sigma_gradient = {0.0, 0.0, -1.6 * std::numbers::pi * std::sin(2.0 * std::numbers::pi * x.z())}};
}

constexpr int kBins = 20;

double worst_of(const Eigen::ArrayXd& z) {
  Eigen::ArrayXd count = Eigen::ArrayXd::Zero(kBins);
  for (const double place : z)
    count[std::min(kBins - 1, static_cast<int>((place - std::floor(place)) * kBins))] += 1.0;
  return (count * kBins / static_cast<double>(z.size()) - 1.0).abs().maxCoeff();
}

double start_of(Eigen::Index n, Eigen::Index count) {
  return (static_cast<double>(n) + 0.5) / static_cast<double>(count);
}

/// u' that relaxes to the local energy and nothing else.
double naive_concentration(Eigen::Index particles, double end, double h) {
  const double kept = std::exp(-h / kWaveTime), noise = std::sqrt(1.0 - kept * kept);
  Eigen::ArrayXd z(particles);
  for (Eigen::Index n = 0; n < particles; ++n) {
    Stream random(3, static_cast<std::uint64_t>(n));
    double place = start_of(n, particles), u = wave_sigma(place) * random.normal();
    for (double t = 0.0; t < end - 0.5 * h; t += h) {
      place += 0.5 * h * u;
      u = kept * u + noise * wave_sigma(place) * random.normal();
      place += 0.5 * h * u;
    }
    z[n] = place;
  }
  return worst_of(z);
}

void run_well_mixed(const Options& options) {
  const Eigen::Index particles = options.quick ? 50000 : 200000;
  const auto flow = models::turbulent_flow(
      [](double, const Eigen::Vector3d&) { return models::AmbientSample{}; }, wave, 1.0);
  Eigen::Matrix3Xd start = Eigen::Matrix3Xd::Zero(3, particles);
  for (Eigen::Index n = 0; n < particles; ++n) start(2, n) = start_of(n, particles);
  constexpr double kEnd = 5.0, kStep = 0.1 * kWaveTime;
  const double end[] = {kEnd};
  const auto paths = models::follow_fluid(*flow, start, end, {.step = kStep, .seed = 5, .C_0 = kC0});
  print({.bench = "realise",
         .test_case = "well_mixed",
         .metric = "concentration_error",
         .value = worst_of(paths.position[0].row(2).transpose().array())});
  print({.bench = "realise",
         .test_case = "well_mixed",
         .metric = "concentration_error_naive",
         .value = naive_concentration(particles / 4, kEnd, kStep)});
}

/// Velocities at the times, all components, where sigma = 1 and T = 1.
std::vector<Eigen::ArrayXd> unit_velocities(const std::vector<double>& times, double step) {
  const Eigen::Matrix3Xd start = Eigen::Matrix3Xd::Zero(3, 70000);
  const auto paths = models::follow_fluid(*models::uniform_turbulence(1.5, dissipation(1.5, 1.0)), start,
                                          times, {.step = step, .seed = 9, .C_0 = kC0});
  std::vector<Eigen::ArrayXd> all;
  for (const Eigen::Matrix3Xd& at : paths.velocity) all.emplace_back(at.reshaped().array());
  return all;
}

void run_stationary() {
  double worst = 0.0;
  for (const auto& u : unit_velocities({1.0, 2.0, 3.0, 4.0, 5.0}, 1.0))
    worst = std::max(worst, std::abs(u.square().mean() - 1.0));
  print({.bench = "realise", .test_case = "stationary_h_T", .metric = "variance_error", .value = worst});
}

void run_structure_function() {
  double worst = 0.0;
  for (const double h : {0.1, 0.5, 1.0, 2.0}) {
    const auto u = unit_velocities({0.0, h}, h);
    const double expected = 2.0 * (1.0 - std::exp(-h));
    worst = std::max(worst, std::abs((u[1] - u[0]).square().mean() / expected - 1.0));
  }
  print({.bench = "realise", .test_case = "structure_function", .metric = "error", .value = worst});
}

}  // namespace

void run_particles(const Options& options) {
  if (options.wants("well_mixed")) run_well_mixed(options);
  if (options.wants("stationary_h_T")) run_stationary();
  if (options.wants("structure_function")) run_structure_function();
}

}  // namespace samara::benchmarks
