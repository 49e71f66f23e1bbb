#include "samara/models/stochastic/fluid_seen.h"

#include <array>
#include <numbers>

#include <catch2/catch.hpp>

#include "langevin_figures.h"
#include "samara/base/errors.h"
#include "samara/models/stochastic/fluid_particles.h"
#include "samara/models/stochastic/turbulent_action.h"
#include "wavy_energy.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// sigma = 1, T = 1
std::shared_ptr<const TurbulentFlow> unit_turbulence() {
  return uniform_turbulence(1.5, dissipation(1.5, 1.0));
}

ProcessRecord fluid_process(double h, long steps, long samples) {
  const long particles = samples / 3;  // three components each
  std::vector<double> times;
  for (long k = 0; k <= steps; ++k) times.push_back(static_cast<double>(k) * h);
  const ParticlePaths paths = follow_fluid(*unit_turbulence(), Eigen::Matrix3Xd::Zero(3, particles), times,
                                           {.step = 1.0001 * h, .seed = 3, .C_0 = kC0});
  ProcessRecord record = {Eigen::MatrixXd(3 * particles, steps + 1),
                          Eigen::MatrixXd(3 * particles, steps + 1)};
  for (long k = 0; k <= steps; ++k) {
    const auto at = static_cast<std::size_t>(k);
    record.u.col(k) = paths.velocity[at].reshaped();
    record.x.col(k) = paths.position[at].reshaped();
  }
  return record;
}

constexpr long kMixed = 60000, kParting = 20000;
constexpr int kBins = 20;

/// Largest distance of the concentration from 1 after a second (10 T) of fluid that was mixed at first.
double worst_concentration(const TurbulentFlow& flow, double step) {
  Eigen::Matrix3Xd start = Eigen::Matrix3Xd::Zero(3, kMixed);
  for (Eigen::Index n = 0; n < start.cols(); ++n) start(2, n) = (static_cast<double>(n) + 0.5) / kMixed;
  const double end[] = {1.0};
  const ParticlePaths paths = follow_fluid(flow, start, end, {.step = step, .seed = 5, .C_0 = kC0});
  return (concentrations(paths.position[0].row(2).array(), kBins).array() - 1.0).abs().maxCoeff();
}

/// The same for a toy that relaxes to the local energy without any drift: either w = u/sigma, or u itself.
double worst_concentration_without_drift(bool relaxes_w) {
  const WavyEnergy flow(0.0, 0.0);
  constexpr double h = 0.01;
  const double kept = std::exp(-h / 0.1), noise = std::sqrt(1.0 - kept * kept);
  Eigen::ArrayXd z(kParting);
  for (long n = 0; n < kParting; ++n) {
    samara::Stream random(17, static_cast<std::uint64_t>(n));
    const auto sigma = [&](double place) {
      return std::sqrt(flow.turbulence(0.0, {0.0, 0.0, place}).k / 1.5);
    };
    double place = (static_cast<double>(n) + 0.5) / kParting;
    double w = random.normal();
    for (int step = 0; step < 100; ++step) {
      const double before = sigma(place);
      place += 0.5 * h * before * w;
      const double here = sigma(place);
      if (!relaxes_w) w *= before / here;  // u is what stays
      w = kept * w + noise * random.normal();
      place += 0.5 * h * here * w;
      if (!relaxes_w) w *= here / sigma(place);
    }
    z[n] = place;
  }
  return (concentrations(z, kBins).array() - 1.0).abs().maxCoeff();
}

constexpr double kMixedTolerance = 0.06;

}  // namespace

TEST_CASE("particles of the fluid have its variance, memory, increments and spread at every length of step") {
  for (const std::string& fault : faults_of(fluid_process)) FAIL_CHECK(fault);
}

TEST_CASE("processes that have only the right variance are found out") {
  // Euler's steps; the same with an amplitude tuned to the variance; white noise through a filter that is tuned at
  // T/10.
  CHECK(faults_of(stepped([](double u, double h, double z) {
          return u - h * u + std::sqrt(2.0 * h) * z;
        })).size() >= 8);
  const Process tuned = stepped([](double u, double h, double z) {
    const double kept = 1.0 - h;
    return kept * u + std::sqrt(std::max(0.0, 1.0 - kept * kept)) * z;
  });
  CHECK(faults_of(tuned).size() >= 4);
  const Process filtered = stepped([](double u, double, double z) { return 0.9 * u + std::sqrt(0.19) * z; });
  const std::vector<Figure> at_its_own = figures_of(filtered, 0.1, 60000);
  CHECK(at_its_own[0].holds());
  CHECK(faults_of(filtered).size() >= 6);
}

TEST_CASE("turbulence that decays keeps the energy of the closed form in steps of any length") {
  const Turbulence at_end = decaying_energy(1.5, 1.0, 10.0);
  CHECK_THAT(at_end.k, WithinRel(0.17725536585951804, 1e-12));
  CHECK_THAT(at_end.epsilon, WithinRel(0.01656592204294562, 1e-12));
  const double end[] = {10.0};
  const ParticlePaths paths = follow_fluid(*decaying_turbulence(1.5, 1.0), Eigen::Matrix3Xd::Zero(3, 70000),
                                           end, {.step = 1.0, .seed = 2, .C_0 = kC0});
  const double k = 0.5 * paths.velocity[0].squaredNorm() / 70000.0;
  CHECK_THAT(k, WithinRel(at_end.k, 4.0 * std::sqrt(2.0 / 210000.0)));
}

TEST_CASE("mixed fluid stays mixed where its energy has a gradient") {
  CHECK(worst_concentration(WavyEnergy(0.0, 0.0), 0.01) < kMixedTolerance);
  // In a stream across the gradient, while the energy decays.
  CHECK(worst_concentration(WavyEnergy(0.7, 0.3), 0.01) < kMixedTolerance);
}

TEST_CASE("mixed fluid parts without the drift, though the variance is right at every place") {
  CHECK(worst_concentration_without_drift(true) > 10.0 * kMixedTolerance);
  CHECK(worst_concentration_without_drift(false) > 30.0 * kMixedTolerance);
}

TEST_CASE("the constant of the structure function follows the Reynolds number of Taylor's scale") {
  CHECK_THAT(structure_constant(100.0), WithinRel(5.333962799111289, 1e-12));
  CHECK_THAT(structure_constant(1000.0), WithinRel(6.4325754720073585, 1e-12));
  CHECK_THAT(structure_constant(1e4), WithinRel(6.496833915790819, 1e-12));
}

TEST_CASE("a step of the Langevin equation and two of half its length are the same process") {
  for (const double a : {1e-4, 0.0199, 0.0201, 0.3, 2.0}) {
    const LangevinStep whole(a), half(0.5 * a);
    CHECK_THAT(half.kept * half.kept, WithinRel(whole.kept, 1e-14));
    const double noise = half.noise * half.noise * (1.0 + half.kept * half.kept);
    CHECK_THAT(noise, WithinRel(whole.noise * whole.noise, 1e-10));
    // The integral: of the first half, of what it leaves, and of the second half.
    const double by_first = half.shared + half.carry * half.noise;
    const double variance = by_first * by_first + half.shared * half.shared + 2.0 * half.rest * half.rest;
    CHECK_THAT(variance, WithinRel(whole.shared * whole.shared + whole.rest * whole.rest, 1e-8));
    const double covariance = by_first * half.kept * half.noise + half.shared * half.noise;
    CHECK_THAT(covariance, WithinRel(whole.shared * whole.noise, 1e-10));
  }
}

TEST_CASE("a body that crosses the eddies sees them pass in a shorter time, most across its way") {
  constexpr double speed = 20.0, b = 0.565;
  const double along = 1.0 / std::sqrt(1.0 + b * b * speed * speed);
  const double across = 1.0 / std::sqrt(1.0 + 4.0 * b * b * speed * speed);
  CHECK_THAT(along, WithinRel(1.0 / 11.3, 5e-3));
  const auto source = fluid_seen_in(unit_turbulence(), 4, {.C_0 = kC0});
  constexpr int kPaths = 3000, kSteps = 60;
  for (const bool is_along : {true, false}) {
    const double h = is_along ? along : across;
    double products = 0.0;
    for (std::uint64_t n = 0; n < kPaths; ++n) {
      const auto path = source->realisation(n, false);
      BodyOnPath body = {.velocity = {speed, 0.0, 0.0}};
      body.air = path->start(body).velocity;
      for (int step = 0; step < kSteps; ++step) {
        const Eigen::Vector3d before = body.air;
        body.air = path->step(body, h).velocity;
        body.t += h;
        body.position += h * body.velocity;
        products += is_along ? before.x() * body.air.x()
                             : 0.5 * (before.y() * body.air.y() + before.z() * body.air.z());
      }
    }
    const double correlation = products / (kPaths * kSteps);
    CHECK_THAT(-1.0 / std::log(correlation), WithinRel(1.0, 0.03));
  }
}

TEST_CASE("a body without a drift sees the eddies pass a little fast, and the faster the smaller C_0 is") {
  const auto time_seen = [](double C_0) {
    constexpr double h = 0.2;
    constexpr int kPaths = 1500, kSteps = 300, kForgotten = 150;
    // T = 1, sigma = 1
    const auto source = fluid_seen_in(uniform_turbulence(1.5, 2.0 / C_0), 8, {.C_0 = C_0});
    double products = 0.0, squares = 0.0;
    for (std::uint64_t n = 0; n < kPaths; ++n) {
      const auto path = source->realisation(n, false);
      BodyOnPath body;
      body.air = path->start(body).velocity;
      for (int step = 0; step < kSteps; ++step) {
        const Eigen::Vector3d before = body.air;
        body.air = path->step(body, h).velocity;
        body.t += h;
        if (step < kForgotten) continue;
        products += before.dot(body.air);
        squares += before.squaredNorm();
      }
    }
    return -h / std::log(products / squares);
  };
  const double usual = time_seen(6.5);
  CHECK(usual > 0.9);
  CHECK(usual < 1.0);
  CHECK(time_seen(2.1) < 0.8);
}

TEST_CASE("a disc sees what the average of von Karman's spectrum over it leaves") {
  const auto by_quadrature = [](double radius) {
    double seen = 0.0, all = 0.0;
    constexpr double kStep = 0.05;
    for (double ln_k = std::log(1e-4); ln_k < std::log(1e8); ln_k += kStep) {
      const double k = std::exp(ln_k), energy = k * std::pow(k, 4) / std::pow(1.0 + k * k, 17.0 / 6.0);
      constexpr int kAngles = 120;
      for (int i = 0; i < kAngles; ++i) {
        const double sine = std::sin((i + 0.5) * std::numbers::pi / kAngles), q = radius * k * sine;
        // Beyond it nothing is left.
        const double filter = q < 1e-4 ? 1.0 : q > 500.0 ? 0.0 : 2.0 * std::cyl_bessel_j(1.0, q) / q;
        seen += energy * sine * sine * sine * filter * filter;
        all += energy * sine * sine * sine;
      }
    }
    return seen / all;
  };
  CHECK_THAT(disc_attenuation(0.01), WithinAbs(0.9463, 1e-3));
  CHECK_THAT(disc_attenuation(0.1), WithinAbs(0.7568, 1e-3));
  CHECK_THAT(disc_attenuation(0.3), WithinAbs(0.5299, 1e-3));
  CHECK_THAT(disc_attenuation(1.0), WithinAbs(0.1949, 1e-3));
  for (const double radius : {0.07, 0.4, 1.9})
    CHECK_THAT(disc_attenuation(radius), WithinAbs(by_quadrature(radius), 1e-3));
  CHECK(disc_attenuation(0.0) == 1.0);
  CHECK_THAT(disc_attenuation(1e-4), WithinAbs(disc_attenuation(0.9999e-4), 1e-5));
  CHECK_THAT(disc_attenuation(100.0), WithinRel(disc_attenuation(99.99), 1e-3));
}

TEST_CASE("a rotational gust has the deviation and the memory of the eddies larger than the body") {
  const double epsilon = dissipation(1.5, 1.0), rate = std::cbrt(epsilon / (0.1 * 0.1));
  const auto source = fluid_seen_in(unit_turbulence(), 6, {.C_0 = kC0, .radius = 0.05, .rotation = true});
  double squares = 0.0, products = 0.0;
  constexpr int kPaths = 20000;
  for (std::uint64_t n = 0; n < kPaths; ++n) {
    const auto path = source->realisation(n, false);
    BodyOnPath body;
    const AirSeen start = path->start(body);
    body.air = start.velocity;
    const AirSeen then = path->step(body, 1.0 / rate);
    squares += then.rotation.squaredNorm() / 3.0;
    products += start.rotation.dot(then.rotation) / 3.0;
  }
  const auto still = fluid_seen_in(uniform_turbulence(0.0, 1.0), 6, {.radius = 0.05, .rotation = true});
  CHECK(still->realisation(0, false)->start({}).rotation.isZero(0.0));
  const double variance = 0.99 * 0.99 * rate * rate;
  CHECK_THAT(squares / kPaths, WithinRel(variance, 4.0 * std::sqrt(2.0 / (3.0 * kPaths))));
  CHECK_THAT(products / squares, WithinAbs(std::exp(-1.0), 4.0 / std::sqrt(3.0 * kPaths)));
}

TEST_CASE("flows and options outside their meaning are refused") {
  CHECK_THROWS_WITH(uniform_turbulence(-1.0, 1.0), Catch::Matchers::Contains("k [m^2/s^2] is -1"));
  CHECK_THROWS_WITH(uniform_turbulence(1.0, 0.0), Catch::Matchers::Contains("epsilon [m^2/s^3] is 0"));
  CHECK_THROWS_AS(decaying_turbulence(1.0, NAN), samara::ArgumentError);
  CHECK_THROWS_AS(fluid_seen_in(nullptr, 1), samara::ArgumentError);
  CHECK_THROWS_WITH(fluid_seen_in(unit_turbulence(), 1, {.rotation = true}),
                    Catch::Matchers::Contains("the radius of the body was expected"));
  CHECK_THROWS_AS(structure_constant(-1.0), samara::ArgumentError);
}

TEST_CASE(
    "the action of a path that turbulence made is 3/2 an interval, whatever the interval, and its "
    "derivatives are "
    "those by differences") {
  const Turbulence energy = {.k = 1.5, .epsilon = dissipation(1.5, 1.0)};
  const SeenOptions options = {.C_0 = kC0};
  for (const double h : {0.01, 0.001}) {
    constexpr Eigen::Index kSteps = 4000;
    samara::Stream random(23, h < 0.005);
    TurbulentPath path = {.times = Eigen::VectorXd::LinSpaced(kSteps + 1, 0.0, h * kSteps),
                          .velocities = Eigen::MatrixX3d(kSteps + 1, 3),
                          .still = Eigen::RowVector3d(0.0, 0.0, -9.81).replicate(kSteps, 1),
                          .fluid = Eigen::RowVector3d(2.0, 0.0, 0.0).replicate(kSteps, 1)};
    path.velocities.row(0) << 2.0, 0.0, -9.81;  // where it falls with T = 1
    for (Eigen::Index i = 0; i < kSteps; ++i) {
      for (Eigen::Index j = 0; j < 3; ++j) {
        const double slip = path.velocities(i, j) - path.fluid(i, j);
        path.velocities(i + 1, j) = path.velocities(i, j) + (path.still(i, j) - slip) * h +
                                    std::sqrt(kC0 * energy.epsilon * h) * random.normal();
      }
    }
    const TurbulentAction action = turbulent_action(path, {energy}, options);
    CHECK_THAT(action.value / kSteps, WithinAbs(1.5, 4.0 * std::sqrt(1.5 / kSteps)));
    // Without the pull of the fluid, or with another fall, the same path is less likely.
    TurbulentPath other = path;
    other.still.col(2).setZero();
    CHECK(turbulent_action(other, {energy}, options).value > action.value + 20.0 * h);
    // Quadratic: central differences are exact but for rounding.
    for (const Eigen::Index i : {Eigen::Index{0}, kSteps / 2}) {
      TurbulentPath above = path, below = path;
      above.still(i, 1) += 1.0;
      below.still(i, 1) -= 1.0;
      const double slope = 0.5 * (turbulent_action(above, {energy}, options).value -
                                  turbulent_action(below, {energy}, options).value);
      CHECK_THAT(action.by_still(i, 1), WithinAbs(slope, 1e-8));
    }
  }
  // What a planner pays for an acceleration that it holds is that of a path with it, and without other noise.
  TurbulentPath held = {.times = Eigen::Vector2d(0.0, 0.25),
                        .velocities = Eigen::MatrixX3d::Zero(2, 3),
                        .still = Eigen::MatrixX3d::Zero(1, 3),
                        .fluid = {}};
  held.velocities.row(1) << 0.5, 0.25, 0.0;
  CHECK_THAT(turbulent_action({2.0, 1.0, 0.0}, 0.25, energy, options),
             WithinRel(turbulent_action(held, {energy}, options).value, 1e-14));
  CHECK_THROWS_WITH(turbulent_action({1.0, 0.0, 0.0}, 0.1, {}, options),
                    Catch::Matchers::Contains("k of the turbulence"));
  held.times[1] = 0.0;
  CHECK_THROWS_WITH(turbulent_action(held, {energy}, options),
                    Catch::Matchers::Contains("times that increase"));
}
