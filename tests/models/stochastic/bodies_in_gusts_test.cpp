#include <mutex>
#include <numbers>

#include <catch2/catch.hpp>

#include "langevin_figures.h"
#include "samara/models/equations/equation_model.h"
#include "samara/models/laws/registry.h"
#include "samara/models/stochastic/fluid_seen.h"
#include "samara/models/stochastic/realisations.h"
#include "samara/models/stochastic/response_time.h"
#include "wavy_energy.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// A sphere with a drag of drag * v, c = 1/2 rho A C_D Re_drag nu/diameter.
ParametricModel linear_body(double drag, std::map<std::string, double> values) {
  values.merge(std::map<std::string, double>{{"diameter", 1.0},
                                             {"C_D", 1e-12},
                                             {"C_M", 0.0},
                                             {"Re_drag", 1e12},
                                             {"nu", 1.0},
                                             {"fluid_density", 8.0 * drag / std::numbers::pi},
                                             {"displaced_mass", 0.0},
                                             {"added_mass", 0.0},
                                             {"inertia", 1.0},
                                             {"g", 0.0}});
  return {find_model("sphere_flight_in_gusts"), values, {}};
}

/// As heavy as the fluid.
ParametricModel neutral_plate() {
  return {find_model("falling_plate_in_gusts"),
          {{"semi_chord", 0.1}, {"semi_thickness", 0.05}, {"density", 998.2}, {"fluid_density", 998.2}},
          {}};
}

/// The energy begins after the start, so that what moves with the fluid does so from the first step on.
std::shared_ptr<const AirSource> wavy_air() {
  const WavyEnergy wavy(0.0, 0.0);
  const auto energy = [wavy](double t, const Eigen::Vector3d& x) {
    return t > 0.0 ? wavy.turbulence(t, x) : Turbulence();
  };
  return fluid_seen_in(
      turbulent_flow([](double, const Eigen::Vector3d&) { return AmbientSample(); }, energy, 1.0), 3,
      {.C_0 = kC0});
}

/// Of a cloud that all started at one place, by height, long after.
Eigen::VectorXd concentration_of(const ParametricModel& body) {
  const std::vector<double> end = {3.0};
  const long count = 2048;
  const Ensemble cloud =
      realise(body, {}, *wavy_air(), end, {.realisations = count, .step = 0.01, .keep = count});
  const Eigen::Index height = body.model().info().states[5].name == "y" ? 5 : 2;
  Eigen::ArrayXd z(count);
  for (Eigen::Index n = 0; n < z.size(); ++n) z[n] = cloud.kept[static_cast<std::size_t>(n)](0, height);
  return concentrations(z, 5);
}

/// Sums up what bodies were told at one of their steps.
class Recorder final : public AirSource {
 public:
  Recorder(std::shared_ptr<const AirSource> real, int at) : real_(std::move(real)), at_(at) {}
  std::unique_ptr<AirAlongPath> realisation(std::uint64_t number, bool mirrored) const override {
    return std::make_unique<Path>(*this, real_->realisation(number, mirrored));
  }
  double mean_upward() const { return sum_ / count_; }

 private:
  class Path final : public AirAlongPath {
   public:
    Path(const Recorder& to, std::unique_ptr<AirAlongPath> real) : to_(to), real_(std::move(real)) {}
    AirSeen start(const BodyOnPath& body) override { return real_->start(body); }
    AirSeen step(const BodyOnPath& body, double h) override {
      const AirSeen seen = real_->step(body, h);
      if (++step_ == to_.at_) {
        const std::scoped_lock lock(to_.mutex_);
        to_.sum_ += seen.velocity.z();
        to_.count_ += 1.0;
      }
      return seen;
    }
    bool needs_response() const override { return real_->needs_response(); }

   private:
    const Recorder& to_;
    std::unique_ptr<AirAlongPath> real_;
    int step_ = 0;
  };

  std::shared_ptr<const AirSource> real_;
  int at_;
  mutable std::mutex mutex_;
  mutable double sum_ = 0.0, count_ = 0.0;
};

/// A plate without inertia of the fluid, with drag alone.
std::shared_ptr<const Model> written_plate() {
  Equations plate = {.name = "written_plate",
                     .states = {{.name = "vx", .unit = "m/s"},
                                {.name = "vy", .unit = "m/s"},
                                {.name = "w", .unit = "1/s"},
                                {.name = "theta", .unit = "1"},
                                {.name = "x", .unit = "m"},
                                {.name = "y", .unit = "m"}},
                     .parameters = {{.name = "drag", .unit = "1/s"}}};
  const auto gust = [&](const std::string& name, const std::string& unit) {
    plate.parameters.push_back({.name = name, .unit = unit, .default_value = 0.0});
  };
  gust("gust_start", "s");
  for (const char* axis : {"x", "y"}) {
    const std::string of = axis;
    gust("gust_" + of, "m/s");
    gust("gust_rate_" + of, "m/s^2");
    gust("gust_gradient_" + of + "x", "1/s");
    gust("gust_gradient_" + of + "y", "1/s");
    plate.rates.push_back("drag*(gust_" + of + " + gust_rate_" + of + "*(t - gust_start) - v" + of +
                          ") + 0*v" + of + "*(gust_gradient_" + of + "x + gust_gradient_" + of + "y)");
  }
  gust("gust_spin", "1/s");
  plate.rates.insert(plate.rates.end(), {"0*drag*gust_spin", "w", "vx", "vy"});
  return equation_model(plate);
}

}  // namespace

TEST_CASE("bodies as heavy as the fluid stay mixed with it, heavy ones gather where it is calm") {
  // Five bins of 410 each scatter by 5 %; without the drift the calm one would have three times as many.
  const auto sphere = [](double mass) {
    return linear_body(100.0, {{"mass", mass}, {"displaced_mass", 1.0}, {"added_mass", 0.5}});
  };
  CHECK((concentration_of(sphere(1.0)).array() - 1.0).abs().maxCoeff() < 0.2);
  CHECK((concentration_of(neutral_plate()).array() - 1.0).abs().maxCoeff() < 0.2);
  // A tracer by drag alone: its response time is T/20.
  CHECK((concentration_of(linear_body(20.0, {{"mass", 0.1}})).array() - 1.0).abs().maxCoeff() < 0.2);
  // Turbophoresis, here with a response time of 2 T (M. W. Reeks, J. Aerosol Sci. 14 (1983) 729-739).
  const Eigen::VectorXd heavy = concentration_of(sphere(20.0));
  CHECK(heavy[2] > heavy[0] + heavy[4]);
}

TEST_CASE("a linear body has the share of the fluid's energy that its response time leaves") {
  // In units where the fluid has sigma = 1, T = 1.
  struct Case {
    double tau;
    bool crossing;
    double tolerance;
  };
  // What is random in the mean relative velocity shortens T a little for bodies that hardly move.
  for (const auto& [tau, crossing, tolerance] :
       {Case{0.01, true, 0.015}, Case{0.1, true, 0.015}, Case{1.0, true, 0.015}, Case{10.0, true, 0.025},
        Case{10.0, false, 0.015}}) {
    const auto air =
        fluid_seen_in(uniform_turbulence(1.5, dissipation(1.5, 1.0)), 3, {.C_0 = kC0, .crossing = crossing});
    std::vector<double> times;
    for (int k = 0; k < 20; ++k) times.push_back(5.0 * (1.0 + tau) + 2.0 * k * (1.0 + tau));
    const double step = tau < 0.05 ? 0.02 : 0.1;
    const Ensemble cloud = realise(linear_body(1.0, {{"mass", tau}}), {}, *air, times,
                                   {.realisations = 1024, .step = step, .states = {"vx", "vy", "vz"}});
    double energy = 0.0;
    for (const Eigen::MatrixXd& covariance : cloud.covariance) energy += covariance.trace() / 60.0;
    CHECK_THAT(energy, WithinRel(1.0 / (1.0 + tau), tolerance));
  }
}

TEST_CASE("a body that is held or drifts through the eddies sees their whole variance") {
  const auto source = fluid_seen_in(uniform_turbulence(1.5, dissipation(1.5, 1.0)), 8, {.C_0 = kC0});
  constexpr int kPaths = 4000, kSamples = 10;
  for (const double speed : {0.0, 1.0, 4.0}) {
    double squares = 0.0;
    for (std::uint64_t n = 0; n < kPaths; ++n) {
      const auto path = source->realisation(n, false);
      BodyOnPath body = {.velocity = {0.0, 0.0, speed}};
      body.air = path->start(body).velocity;
      for (int step = 1; step <= 15 * kSamples; ++step) {
        body.air = path->step(body, 0.1).velocity;
        if (step % 15 == 0) squares += body.air.squaredNorm();
      }
    }
    constexpr double kCount = 3.0 * kPaths * kSamples;
    CHECK_THAT(squares / kCount, WithinAbs(1.0, 4.0 * std::sqrt(2.0 / kCount)));
  }
}

TEST_CASE("a plate in a plane neither sees nor crosses what blows out of it") {
  const std::vector<double> times = {0.5};
  const auto path_in = [&](double across) {
    const auto air = fluid_seen_in(uniform_turbulence(0.1, 0.2, {0.5, across, 0.1}), 7, {.C_0 = kC0});
    return realise(neutral_plate(), {}, *air, times, {.realisations = 1, .keep = 1}).kept[0];
  };
  CHECK(path_in(0.0) == path_in(5.0));
  // What moves with the fluid has its memory: the energy begins after the start, so that there is no slip.
  const auto begins =
      turbulent_flow([](double, const Eigen::Vector3d&) { return AmbientSample(); },
                     [](double t, const Eigen::Vector3d&) {
                       return Turbulence{.k = t > 0.0 ? 1.5 : 0.0, .epsilon = dissipation(1.5, 1.0)};
                     },
                     1.0);
  constexpr int kLags = 10, kFlights = 512;
  std::vector<double> each_T;
  for (int k = 0; k <= kLags; ++k) each_T.push_back(0.1 + k);
  const Ensemble cloud = realise(neutral_plate(), {}, *fluid_seen_in(begins, 2, {.C_0 = kC0}), each_T,
                                 {.realisations = kFlights, .step = 0.1, .keep = kFlights});
  double products = 0.0;
  for (const Eigen::MatrixXd& path : cloud.kept)
    products += path.leftCols(2).topRows(kLags).cwiseProduct(path.leftCols(2).bottomRows(kLags)).sum();
  CHECK_THAT(products / (2.0 * kLags * kFlights), WithinAbs(std::exp(-1.0), 0.05));
}

TEST_CASE("the response time of a linear body is its mass over its drag") {
  const ParametricModel body = linear_body(
      3.0, {{"mass", 2.0}, {"displaced_mass", 0.4}, {"added_mass", 0.5}, {"vx(0)", 0.7}, {"g", 9.81}});
  Lanes lanes(body, *body.model().step_kernels()->scalar, {});
  lanes.load(0, {});
  lanes.complete();
  const GustLayout layout(body.model());
  ResponseTime response(body, {}, layout);
  CHECK_THAT(response(lanes, 0, 0.3, {0.1, -0.4, 2.0}), WithinRel(2.5 / 3.0, 1e-11));
  CHECK(std::isinf(response(lanes, 0, 0.3, {0.7, 0.0, 0.0})));
}

TEST_CASE("a heavy body that crosses a gradient of the energy sees gusts of zero mean") {
  // Twice the deviation a second, to where the gradient is the largest; what follows the fluid sees 0.3.
  const double tau = 10.0;
  const ParametricModel body = linear_body(1.0, {{"mass", tau}, {"g", 2.0 / tau}, {"vz(0)", -2.0}});
  const std::vector<double> end = {0.12};
  const Recorder air(wavy_air(), 12);
  realise(body, {}, air, end, {.realisations = 4096, .step = 0.01});
  CHECK(std::abs(air.mean_upward()) < 4.0 / std::sqrt(4096.0));
}

TEST_CASE("gusts change along the path of the fluid as their deviation does") {
  const WavyEnergy flow(0.7, 0.0);
  const Eigen::Vector3d stream(0.0, 0.0, 0.7);
  const auto sigma = [&](const Eigen::Vector3d& x) { return std::sqrt(flow.turbulence(0.0, x).k / 1.5); };
  const auto source = fluid_seen_in(std::make_shared<WavyEnergy>(0.7, 0.0), 3, {.C_0 = kC0});
  const auto path = source->realisation(5, false);
  BodyOnPath body = {.position = {0.0, 0.0, 0.1}, .velocity = {0.2, 0.0, 0.3}};
  body.air = path->start(body).velocity;
  constexpr double h = 0.02;
  const AirSeen seen = path->step(body, h);
  const Eigen::Vector3d w = 0.5 * ((body.air - stream) / sigma(body.position) +
                                   (seen.velocity - stream) / sigma(body.position + h * body.velocity));
  const Turbulence middle = flow.turbulence(0.0, body.position + 0.5 * h * body.velocity);
  CHECK((seen.gradient - w * middle.sigma_gradient.transpose()).norm() < 1e-12);
  CHECK(seen.gradient.norm() > 0.5);
}

TEST_CASE("a model from equations flies through gusts as they are") {
  const ParametricModel plate(written_plate(), {{"drag", 3.0}}, {});
  const std::vector<double> times = {0.5};
  const auto stream = fluid_seen_in(uniform_turbulence(0.0, 1.0, {1.0, 0.0, -0.5}), 1);
  const Ensemble calm = realise(plate, {}, *stream, times, {.realisations = 2, .keep = 2});
  CHECK_THAT(calm.kept[1](0, 0), WithinRel(1.0 - std::exp(-1.5), 1e-10));
  CHECK_THAT(calm.kept[1](0, 1), WithinRel(-0.5 * (1.0 - std::exp(-1.5)), 1e-10));
  const Ensemble cloud = realise(plate, {}, *fluid_seen_in(uniform_turbulence(0.1, 0.2), 1, {.C_0 = kC0}),
                                 times, {.realisations = 64});
  CHECK(cloud.standard_deviation(0, 0) > 1e-3);
}

TEST_CASE("a body that comes to the ground where the flow ends has landed") {
  const auto above_ground =
      turbulent_flow([](double, const Eigen::Vector3d&) { return AmbientSample(); },
                     [](double, const Eigen::Vector3d& x) {
                       return Turbulence{.k = 0.1, .epsilon = 0.2, .inside = x.z() > 0.0};
                     },
                     1.0);
  const ParametricModel ball(find_model("sphere_flight_in_gusts"), {{"z(0)", 0.3}}, {});
  const std::vector<double> times = {1.0};
  const auto air = fluid_seen_in(above_ground, 4, {.C_0 = kC0});
  const Ensemble with_ground = realise(ball, {}, *air, times, {.realisations = 64, .ground = 0.0});
  CHECK(with_ground.count(RealisationStatus::landed) == 64);
  for (const Landing& landing : with_ground.landings) CHECK(std::abs(landing.position.z()) < 1e-12);
  CHECK(realise(ball, {}, *air, times, {.realisations = 64}).count(RealisationStatus::left_flow) == 64);
}

TEST_CASE("intervals of the quantiles of landings hold the true ones as often as they say") {
  constexpr int kEnsembles = 400, kLandings = 60;
  constexpr double kTruth[] = {-1.6448536269514722, -0.6744897501960817, 0.0, 0.6744897501960817,
                               1.6448536269514722};
  Eigen::Array<double, 5, 1> held = Eigen::Array<double, 5, 1>::Zero();
  for (int e = 0; e < kEnsembles; ++e) {
    samara::Stream random(41, static_cast<std::uint64_t>(e));
    Ensemble cloud;
    for (int n = 0; n < kLandings; ++n)
      cloud.landings.push_back({.realisation = n, .t = 1.0, .position = {random.normal(), 0.0, 0.0}});
    const LandingStatistics landing = landing_statistics(cloud);
    for (Eigen::Index i = 0; i < 5; ++i) {
      const double lower = landing.quantiles_lower(i, 0), upper = landing.quantiles_upper(i, 0);
      CHECK((!(lower > landing.quantiles(i, 0)) && !(upper < landing.quantiles(i, 0))));
      // An end that the sample does not reach leaves that side open.
      held[i] += !(lower > kTruth[i]) && !(upper < kTruth[i]);
    }
    // 0.95^60 = 0.046: the largest of 60 is below the upper quantile too often to be an end.
    CHECK(std::isnan(landing.quantiles_upper(4, 0)));
    CHECK(std::isnan(landing.quantiles_lower(0, 0)));
    CHECK(std::isfinite(landing.quantiles_lower(4, 0)));
  }
  // At least 95 %, a little more for the steps between order statistics; 0.02 is 1.8 deviations of 400.
  for (const double share : held / kEnsembles) CHECK((share > 0.93 && share < 0.995));
}
