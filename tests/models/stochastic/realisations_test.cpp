#include "samara/models/stochastic/realisations.h"

#include <cstring>
#include <mutex>
#include <random>

#include <catch2/catch.hpp>

#include "leaves_in_gusts.h"
#include "samara/base/errors.h"
#include "samara/models/batch/batch.h"
#include "samara/models/laws/registry.h"
#include "samara/models/stochastic/fluid_seen.h"
#include "wavy_energy.h"

using namespace samara::models;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;

namespace {

ParametricModel plate() {
  return {find_model("falling_plate_in_gusts"),
          {{"semi_chord", 0.02}, {"semi_thickness", 0.002}, {"density", 1500.0}, {"w(0)", 40.0}},
          {}};
}

/// Its flow comes from angles on both sides of 45 degrees.
ParametricModel blimp() {
  return {find_model("coefficient_body_in_gusts"),
          {{"mass", 0.16},
           {"displaced_mass", 0.15},
           {"I_x", 0.03},
           {"I_y", 0.015},
           {"I_z", 0.01},
           {"area", 0.25},
           {"Cd0", 0.24},
           {"Cla", 2.9},
           {"Csb", -2.1},
           {"Cmya", 0.09},
           {"K1", -0.05},
           {"K2", -0.026},
           {"K3", -0.014},
           {"ux(0)", 0.6},
           {"uz(0)", 0.5}},
          {}};
}

const std::vector<double> kTimes = {0.0, 0.1, 0.2};

bool same_bits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

bool same_bits(const Ensemble& a, const Ensemble& b) {
  bool same = same_bits(a.mean, b.mean) && same_bits(a.mean_error, b.mean_error) && a.status == b.status &&
              a.half_turns == b.half_turns && a.kept.size() == b.kept.size() &&
              a.landings.size() == b.landings.size();
  for (std::size_t k = 0; same && k < a.covariance.size(); ++k)
    same = same_bits(a.covariance[k], b.covariance[k]) &&
           same_bits(a.covariance_error[k], b.covariance_error[k]);
  for (std::size_t n = 0; same && n < a.kept.size(); ++n) same = same_bits(a.kept[n], b.kept[n]);
  for (std::size_t n = 0; same && n < a.landings.size(); ++n)
    same = a.landings[n].t == b.landings[n].t && a.landings[n].position == b.landings[n].position;
  return same;
}

/// The toy of a thousand copies: one generator for all realisations, in the order in which they come.
class SharedGenerator final : public AirSource {
 public:
  std::unique_ptr<AirAlongPath> realisation(std::uint64_t, bool) const override {
    const std::scoped_lock lock(mutex_);
    return std::make_unique<Path>(generator_);
  }

 private:
  class Path final : public AirAlongPath {
   public:
    explicit Path(std::mt19937& generator) : generator_(generator) {}
    AirSeen start(const BodyOnPath&) override { return {}; }
    AirSeen step(const BodyOnPath&, double) override {
      std::normal_distribution<double> normal;
      return {.velocity = {normal(generator_), normal(generator_), normal(generator_)}};
    }

   private:
    std::mt19937& generator_;
  };

  mutable std::mutex mutex_;
  mutable std::mt19937 generator_{1};
};

/// A source that gives its realisations one by one only.
class OneByOne final : public AirSource {
 public:
  explicit OneByOne(std::shared_ptr<const AirSource> real) : real_(std::move(real)) {}
  std::unique_ptr<AirAlongPath> realisation(std::uint64_t number, bool mirrored) const override {
    return real_->realisation(number, mirrored);
  }

 private:
  std::shared_ptr<const AirSource> real_;
};

}  // namespace

TEST_CASE("in still air all realisations are the trajectory of Runge and Kutta") {
  const auto still = fluid_seen_in(uniform_turbulence(0.0, 1.0), 1);
  const Ensemble cloud = realise(leaf(), {}, *still, kTimes, {.realisations = 9, .keep = 9});
  const BatchTrajectories alone = integrate_batch(leaf(), Eigen::MatrixXd(1, 0), kTimes, {.step = 1e-3});
  for (const Eigen::MatrixXd& path : cloud.kept)
    CHECK((path - alone.states.transpose()).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(cloud.standard_deviation(2, 0) < 1e-12);
  CHECK(cloud.mean.row(0) == Eigen::RowVector3d(0.0, 0.0, 1.0));
}

TEST_CASE("a realisation has the same bits alone, in any pack, on any number of threads and after a resume") {
  for (const ParametricModel& model : {leaf(), plate(), blimp()}) {
    const auto air = breeze();
    const Ensemble all = realise(model, {}, *air, kTimes, {.realisations = 600, .threads = 1, .keep = 600});
    CHECK(same_bits(all, realise(model, {}, *air, kTimes, {.realisations = 600, .threads = 2, .keep = 600})));
    const Ensemble ten = realise(model, {}, *air, kTimes, {.realisations = 10, .keep = 10});
    for (std::size_t n = 0; n < 10; ++n) CHECK(same_bits(ten.kept[n], all.kept[n]));
    // Many, as a product that is rounded once less shows now and then only.
    for (long n = 4; n < 600; n += 13) {
      const Ensemble alone = realise(model, {}, *air, kTimes, {.realisations = 1, .first = n, .keep = 1});
      CHECK(same_bits(alone.kept[0], all.kept[static_cast<std::size_t>(n)]));
    }
    // Stopped early.
    const Ensemble begun =
        realise(model, {}, *air, kTimes, {.realisations = 600, .keep = 600, .relative_error = 1e9});
    CHECK(begun.realisations() == 256);
    const Ensemble resumed = resume(begun, model, {}, *air, kTimes, {.realisations = 600, .keep = 600});
    CHECK(same_bits(all, resumed));
    const Ensemble cancelled = realise(
        model, {}, *air, kTimes,
        {.realisations = 600, .keep = 600, .progress = [](const samara::Progress&) { return false; }});
    CHECK(cancelled.cancelled);
    CHECK(same_bits(all, resume(cancelled, model, {}, *air, kTimes, {.realisations = 600, .keep = 600})));
  }
}

TEST_CASE("gusts with gradients and rotation have the same bits one by one as side by side") {
  const auto air = fluid_seen_in(std::make_shared<WavyEnergy>(0.7, 0.3), 7,
                                 {.C_0 = 6.0, .radius = 0.026, .rotation = true});
  for (const ParametricModel& model : {leaf(), plate()}) {
    const RealiseOptions options = {.realisations = 45, .keep = 45};
    const Ensemble together = realise(model, {}, *air, kTimes, options);
    CHECK(together.standard_deviation(2, 0) > 1e-4);
    CHECK(same_bits(together, realise(model, {}, OneByOne(air), kTimes, options)));
    for (long n = 0; n < 45; n += 4) {
      const Ensemble alone = realise(model, {}, *air, kTimes, {.realisations = 1, .first = n, .keep = 1});
      CHECK(same_bits(alone.kept[0], together.kept[static_cast<std::size_t>(n)]));
    }
  }
}

TEST_CASE(
    "energy that is the same everywhere moves bodies as the same energy that is asked for at each place") {
  const Eigen::Vector3d stream(0.8, 0.1, 0.0);
  const std::vector<double> times = {0.0, 0.0131, 0.05, 0.1177, 0.2};  // steps of several lengths
  for (const bool decays : {false, true}) {
    const auto uniform =
        decays ? decaying_turbulence(0.3, 0.9, stream) : uniform_turbulence(0.3, 0.9, stream);
    const auto by_place = samara::models::turbulent_flow(
        [&](double, const Eigen::Vector3d&) { return samara::models::AmbientSample{.velocity = stream}; },
        [&](double t, const Eigen::Vector3d& place) { return uniform->turbulence(t, place); }, 1.0);
    REQUIRE(uniform->is_uniform());
    REQUIRE_FALSE(by_place->is_uniform());
    for (const bool rotates : {false, true}) {
      const samara::models::SeenOptions seen = {.C_0 = 6.0, .radius = 0.026, .rotation = rotates};
      const RealiseOptions options = {.realisations = 21, .keep = 21};
      const Ensemble first = realise(leaf(), {}, *fluid_seen_in(uniform, 7, seen), times, options);
      const Ensemble second = realise(leaf(), {}, *fluid_seen_in(by_place, 7, seen), times, options);
      CHECK(first.standard_deviation(2, 0) > 1e-4);
      for (std::size_t n = 0; n < 21; ++n) CHECK(first.kept[n].isApprox(second.kept[n], 1e-10));
    }
  }
}

TEST_CASE("an ensemble that was plain numbers in between goes on to the same bits") {
  const auto air = breeze();
  const RealiseOptions options = {.realisations = 600, .ground = 0.99, .keep = 300};
  const Ensemble all = realise(leaf(), {}, *air, kTimes, options);
  RealiseOptions some = options;
  some.relative_error = 1e9;
  const std::vector<double> numbers = numbers_of(realise(leaf(), {}, *air, kTimes, some));
  const Ensemble begun = ensemble_of(numbers, leaf(), {}, *air, kTimes, options);
  CHECK(begun.realisations() == 256);
  const Ensemble resumed = resume(begun, leaf(), {}, *air, kTimes, options);
  CHECK(same_bits(all, resumed));
  CHECK(resumed.landings.size() == all.landings.size());
  CHECK(resumed.steps.shortest == all.steps.shortest);
  // Numbers of another call, or too few of them.
  const std::vector<double> other = {0.1};
  CHECK_THROWS_WITH(ensemble_of(numbers, leaf(), {}, *air, other, options), Contains("of another call"));
  CHECK_THROWS_WITH(
      ensemble_of(std::span(numbers).first(numbers.size() - 1), leaf(), {}, *air, kTimes, options),
      Contains("too few"));
  CHECK_THROWS_WITH(numbers_of({}), Contains("not made by realise()"));
}

TEST_CASE("what is done is handed over on the way and where it is cancelled, and goes on to the same bits") {
  const auto air = breeze();
  std::vector<Ensemble> handed;
  const Ensemble cancelled = realise(leaf(), {}, *air, kTimes,
                                     {.realisations = 1000000,
                                      .progress = [&](const samara::Progress&) { return handed.empty(); },
                                      .so_far = [&](const Ensemble& cloud) { handed.push_back(cloud); }});
  REQUIRE(cancelled.cancelled);
  REQUIRE(handed.size() == 2);
  CHECK(handed[0].realisations() == 1024);
  CHECK(handed[1].realisations() == cancelled.realisations());
  const RealiseOptions more = {.realisations = cancelled.realisations() + 256};
  const Ensemble all = realise(leaf(), {}, *air, kTimes, more);
  for (const Ensemble& begun : handed) CHECK(same_bits(all, resume(begun, leaf(), {}, *air, kTimes, more)));
}

TEST_CASE("one generator behind all realisations is found out") {
  const auto path_of_17 = [](const AirSource& air, const RealiseOptions& options) {
    return realise(leaf(), {}, air, kTimes, options).kept[static_cast<std::size_t>(17 - options.first)];
  };
  const RealiseOptions many = {.realisations = 40, .threads = 1, .keep = 40},
                       alone = {.realisations = 1, .first = 17, .threads = 1, .keep = 1};
  CHECK_FALSE(same_bits(path_of_17(SharedGenerator(), many), path_of_17(SharedGenerator(), alone)));
  CHECK(same_bits(path_of_17(*breeze(), many), path_of_17(*breeze(), alone)));
}

TEST_CASE("neighbouring realisations have nothing to do with each other") {
  const std::vector<double> end = {0.3};
  const auto flights_in = [&](const AirSource& air) {
    const Ensemble cloud = realise(leaf(), {}, air, end, {.realisations = 1024, .keep = 1024});
    Eigen::ArrayXd x(1024);
    for (Eigen::Index n = 0; n < 1024; ++n) x[n] = cloud.kept[static_cast<std::size_t>(n)](0, 0);
    x -= x.mean();
    return (x.head(1023) * x.tail(1023)).sum() / x.square().sum();
  };
  CHECK(std::abs(flights_in(*breeze())) < 4.0 / std::sqrt(1024.0));
  CHECK(flights_in(Twins(breeze())) > 0.3);
}

TEST_CASE("an energy that is none makes realisations not finite, and nothing else") {
  const double nan = std::nan("");
  for (const auto& [k, epsilon] : {std::pair{-1.0, 1.0}, {1.0, -1.0}, {1.0, 0.0}, {1.0, nan}, {nan, 1.0}}) {
    const auto flow = turbulent_flow([](double, const Eigen::Vector3d&) { return AmbientSample(); },
                                     [k = k, epsilon = epsilon](double, const Eigen::Vector3d& x) {
                                       // Leaves fall into it.
                                       return x.z() > 0.99 ? Turbulence{.k = 0.1, .epsilon = 0.2}
                                                           : Turbulence{.k = k, .epsilon = epsilon};
                                     },
                                     1.0);
    for (const SeenOptions& options :
         {SeenOptions{}, SeenOptions{.C_0 = 6.0, .radius = 0.02, .rotation = true}}) {
      const Ensemble cloud = realise(leaf(), {}, *fluid_seen_in(flow, 3, options), std::vector<double>{0.5},
                                     {.realisations = 8});
      CHECK(cloud.count(RealisationStatus::not_finite) == 8);
    }
  }
}

TEST_CASE("an ensemble is resumed as it was begun or not at all") {
  const auto air = breeze();
  const RealiseOptions options = {.realisations = 512, .ground = -1.0, .relative_error = 1e9};
  const Ensemble begun = realise(leaf(), {}, *air, kTimes, options);
  const auto resumed = [&](const auto& change, double height = 1.0) {
    RealiseOptions other = options;
    change(other);
    return resume(begun, leaf(height), {}, *air, kTimes, other);
  };
  CHECK_NOTHROW(resumed([](RealiseOptions&) {}));
  CHECK_THROWS_WITH(resumed([](RealiseOptions& other) { other.antithetic = true; }),
                    Contains("has other pairs"));
  CHECK_THROWS_WITH(resumed([](RealiseOptions& other) {
                      other.states = {"z", "y", "x"};
                    }),
                    Contains("has other states"));
  CHECK_THROWS_WITH(resumed([](RealiseOptions& other) { other.step = 2e-3; }), Contains("has another step"));
  CHECK_THROWS_WITH(resumed([](RealiseOptions& other) { other.ground = -2.0; }),
                    Contains("has another ground"));
  CHECK_THROWS_WITH(resumed([](RealiseOptions& other) { other.keep = 3; }), Contains("trajectories kept"));
  CHECK_THROWS_WITH(resumed([](RealiseOptions&) {}, 2.0), Contains("other values of the model"));
}

TEST_CASE("a realisation that leaves the flow or is not finite ends with that, and harms no other") {
  const auto with_end = turbulent_flow(
      [](double, const Eigen::Vector3d&) {
        return AmbientSample{.velocity = {1.0, 0.0, 0.0}};
      },
      [](double, const Eigen::Vector3d& x) {
        return Turbulence{.k = x.z() < 0.5 ? -1.0 : 0.1, .epsilon = 0.1, .inside = x.x() < 0.6};
      },
      1.0);
  const std::vector<double> times = {0.0, 0.2, 2.0};
  const Ensemble cloud =
      realise(leaf(), {}, *fluid_seen_in(with_end, 5, {.C_0 = 6.0}), times, {.realisations = 64});
  const long left = cloud.count(RealisationStatus::left_flow),
             broken = cloud.count(RealisationStatus::not_finite);
  CHECK(left + broken == 64);
  CHECK(left > 0);
  CHECK(broken > 0);
  CHECK(cloud.flying[0] == 64);
  CHECK(cloud.flying[2] == 0);
}

TEST_CASE("options of realisations outside their meaning are refused") {
  CHECK_THROWS_WITH(realise(leaf(), {}, *breeze(), kTimes, {.realisations = 0}),
                    Contains("realisations is 0"));
  CHECK_THROWS_WITH(realise(leaf(), {}, *breeze(), kTimes, {.step = 0.0}), Contains("step"));
  CHECK_THROWS_WITH(realise(leaf(), {}, *breeze(), kTimes, {.states = {"speed"}}),
                    Contains("no state \"speed\""));
  CHECK_THROWS_WITH(realise(leaf(), {}, *breeze(), kTimes, {.first = 1L << 62}), Contains("first is 4611"));
  CHECK_THROWS_WITH(realise(leaf(), {}, *breeze(), {}, {}), Contains("number of times is 0"));
  CHECK_THROWS_AS(resume({}, leaf(), {}, *breeze(), kTimes), samara::ArgumentError);
}
