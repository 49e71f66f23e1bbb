#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "files.h"
#include "samara/base/streams.h"
#include "samara/identification/files/follow_files.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/following/followed_motion.h"
#include "samara/identification/problem/known_so_far.h"
#include "samara/identification/report/fit_report.h"
#include "samara/identification/report/read_fit.h"
#include "samara/models/equations/equation_model.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "synthetic.h"

using namespace samara;
using namespace samara::identification;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

constexpr double kStiffness = 9.0;    // 1/s^2
constexpr double kDamping = 0.5;      // 1/s
constexpr double kFrameNoise = 3e-3;  // m

std::shared_ptr<const models::Model> oscillator() {
  return models::equation_model({.name = "oscillator",
                                 .states = {{.name = "x", .unit = "m"}, {.name = "v", .unit = "m/s"}},
                                 .parameters = {{.name = "k", .unit = "1/s^2"}, {.name = "c", .unit = "1/s"}},
                                 .rates = {"v", "-k*x - c*v"}});
}

/// From x and v on, every 0.05 s, with noise.
Capture oscillation(const std::string& id, double x, double v, int frames, Stream& random) {
  const double rate = std::sqrt(kStiffness - 0.25 * kDamping * kDamping);
  const std::vector<double> times = even_times(frames, 0.05 * (frames - 1));
  Eigen::VectorXd seen(frames);
  for (Eigen::Index k = 0; k < frames; ++k) {
    const double t = times[static_cast<std::size_t>(k)];
    seen[k] = std::exp(-0.5 * kDamping * t) *
                  (x * std::cos(rate * t) + (v + 0.5 * kDamping * x) / rate * std::sin(rate * t)) +
              kFrameNoise * random.normal();
  }
  return make_capture(id, times, seen);
}

/// Two coefficients, of which clusters say the first less surely than frames do by the factor.
FitResult fit_of_clusters(int clusters, double factor) {
  FitResult fitted{.status = Termination::converged, .model = "oscillator", .clusters = clusters};
  fitted.coefficients = {{.name = "k",
                          .unit = "1/s^2",
                          .value = 9.0,
                          .lower = 4.0,
                          .upper = 16.0,
                          .standard_error = 0.1 * factor,
                          .naive_standard_error = 0.1},
                         {.name = "c",
                          .unit = "1/s",
                          .value = 0.5,
                          .lower = 0.0,
                          .upper = 2.0,
                          .standard_error = 0.05 * factor,
                          .naive_standard_error = 0.05}};
  fitted.naive_covariance = (Eigen::Matrix2d() << 0.01, 0.001, 0.001, 0.0025).finished();
  // Of two clusters: singular.
  fitted.covariance = factor * factor * (Eigen::Matrix2d() << 0.01, -0.005, -0.005, 0.0025).finished();
  return fitted;
}

/// What is followed: x alone.
FollowOptions options_of(FitResult fitted) {
  fitted.setup.compared.outputs = {"x"};
  fitted.noise = {{.outputs = {"x"}, .unit = "m", .value = kFrameNoise}};
  Stream random(1, 0);
  return follow_options(*oscillator(), fitted, oscillation("one", 0.1, 0.2, 5, random));
}

}  // namespace

TEST_CASE(
    "coefficients that two captures teach, and a third one follows, are as far off as their errors say") {
  // Each of the 12 runs has noise and starts of its own. For normal errors of size one the root mean square of 12
  // scores lies below 1.6 in 998 of 1000 cases; the singular covariance of two clusters gave 2.6 and 6.5.
  constexpr int kRuns = 12;
  constexpr double kMost = 1.8, kFarthest = 4.5;
  const auto model = oscillator();
  const auto family = models::step_trajectories(
      model, {}, {{"k", {4.0, 16.0}}, {"c", {0.01, 2.0}}, {"x(0)", {-0.3, 0.3}}, {"v(0)", {-1.0, 1.0}}},
      0.025);
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.loss.length_scale = kFrameNoise;
  options.compared.outputs = {"x"};
  options.unknowns.offsets = std::vector<std::string>{};
  options.starts.count = 1;
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  for (int run = 0; run < kRuns; ++run) {
    Stream random(21, static_cast<std::uint64_t>(run));
    std::vector<Capture> captures;
    for (const char* id : {"a", "b"}) {
      const double x = 0.2 * random.uniform() - 0.1, v = 0.6 * random.uniform() - 0.3;
      captures.push_back(oscillation(id, x, v, 41, random));
    }
    const FitResult fitted = fit(*family, captures, options);
    const Capture third = oscillation("c", 0.1, 0.2, 81, random);
    FollowOptions following = follow_options(*model, fitted, third);
    following.step = 0.025;
    const FollowedMotion motion = follow(model, following, third);
    REQUIRE(motion.names.size() == 4);
    const Eigen::Index last = motion.values.rows() - 1;
    for (std::size_t k = 2; k < 4; ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      const double truth = motion.names[k] == "k" ? kStiffness : kDamping;
      const double score = (motion.values(last, column) - truth) / motion.errors(last, column);
      CAPTURE(run, motion.names[k], motion.values(last, column), motion.errors(last, column));
      CHECK(std::abs(score) < kFarthest);
      squares[column - 2] += score * score;
    }
  }
  CAPTURE(squares.transpose());
  CHECK(squares.maxCoeff() < kRuns * kMost * kMost);
}

TEST_CASE("errors of clusters count where they differ by more than chance, and as wide as Student's") {
  // chi^2 of one degree of freedom lies below 3.84 in 95 of 100 cases: 1.9^2 may be chance, 10^2 is none.
  const KnownSoFar by_chance = known_so_far(fit_of_clusters(2, 1.9));
  CHECK_FALSE(by_chance.is_clustered);
  CHECK(by_chance.errors.isApprox(Eigen::Vector2d(0.1, 0.05)));
  CHECK(by_chance.widened == by_chance.errors);
  const KnownSoFar clustered = known_so_far(fit_of_clusters(2, 10.0));
  CHECK(clustered.is_clustered);
  CHECK(clustered.errors.isApprox(Eigen::Vector2d(1.0, 0.5)));
  // Student's quantile of one degree of freedom is tan(pi (p - 1/2)).
  const double widening = std::tan(0.475 * std::numbers::pi) / 1.959964;
  CHECK((clustered.widened - widening * clustered.errors).norm() < 1e-5 * clustered.widened.norm());
  // Correlations are those of frames.
  CHECK_THAT(clustered.correlation(0, 1), WithinRel(0.2, 1e-12));
}

TEST_CASE("a fit that was read tells errors as wide as the one that was written") {
  FitResult written = fit_of_clusters(10, 10.0);
  for (Coefficient& c : written.coefficients) c.effective_clusters = 3.0;
  const TemporaryDirectory files;
  const FitResult read = read_fit(files.put("fit.json", fit_json(written)));
  CHECK(known_so_far(read).widened.isApprox(known_so_far(written).widened, 1e-6));
}

TEST_CASE("a motion is followed with the correlation of frames and no farther than boxes go") {
  const FollowOptions by_chance = options_of(fit_of_clusters(2, 1.9));
  REQUIRE(by_chance.coefficients.size() == 2);
  // Of the logarithm of k, whose box is positive, and of c.
  const double of_k = 0.1 / 9.0;
  CHECK_THAT(by_chance.coefficient_covariance(0, 0), WithinRel(of_k * of_k, 1e-12));
  CHECK_THAT(by_chance.coefficient_covariance(0, 1), WithinRel(0.2 * of_k * 0.05, 1e-12));
  CHECK_THAT(by_chance.coefficient_covariance(1, 1), WithinRel(0.0025, 1e-12));
  const FollowOptions wide = options_of(fit_of_clusters(2, 100.0));
  CHECK_THAT(wide.coefficients[0].deviation, WithinRel(std::log(4.0) / std::sqrt(12.0), 1e-12));
  CHECK_THAT(wide.coefficients[1].deviation, WithinRel(2.0 / std::sqrt(12.0), 1e-12));
}

TEST_CASE("a coefficient at a bound is held, one not determined may lie anywhere, and warnings name both") {
  FitResult fitted = fit_of_clusters(2, 1.0);
  CHECK(warnings_of_coefficients(*oscillator(), fitted).empty());
  Coefficient &k = fitted.coefficients[0], &c = fitted.coefficients[1];
  k.determined = false;
  k.standard_error = k.naive_standard_error = {};
  c.value = 0.0;
  c.at_bound = true;
  c.standard_error = c.naive_standard_error = {};
  fitted.covariance.setConstant(NAN);
  fitted.naive_covariance.setConstant(NAN);
  const FollowOptions options = options_of(fitted);
  REQUIRE(options.coefficients.size() == 1);
  CHECK(options.coefficients[0].name == "k");
  CHECK_THAT(options.coefficients[0].deviation, WithinRel(12.0 / std::sqrt(12.0) / 9.0, 1e-12));
  CHECK(options.fixed.at("c") == 0.0);
  const Warnings warnings = warnings_of_coefficients(*oscillator(), fitted);
  CAPTURE(text_of(warnings));
  CHECK(warnings.size() == 2);
  CHECK(warnings.has(WarningKind::undetermined, "does not determine k: it begins at 9 1/s^2"));
  CHECK(warnings.has(WarningKind::bounds, "c lies at a bound of its box in the fit: it is held at 0 1/s"));

  fitted.coefficients.push_back(
      {.name = "x(0)", .unit = "m", .value = 0.1, .lower = -0.3, .upper = 0.3, .naive_standard_error = 0.01});
  CHECK(warnings_of_coefficients(*oscillator(), fitted)
            .has(WarningKind::errors, "x(0) was one for all captures of the fit: it is held at 0.1 m"));
}

TEST_CASE("noise is chosen of what the model has, and what is given of it is held") {
  Stream random(5, 0);
  const std::vector captures{oscillation("one", 0.1, 0.0, 31, random)};
  FollowOptions following = options_of(fit_of_clusters(2, 1.0));
  following.start["v"] = {0.0, 0.1};
  following.step = 0.025;
  const std::vector options{following};
  const NoiseSearch search{.rounds = 1};
  const NoiseChoice chosen = choose_noise(oscillator(), options, captures, search);
  CHECK(chosen.velocity > 0.0);
  CHECK(chosen.rate == 0.0);  // no state is one
  const GivenNoise given{.velocity = 0.07, .drift = 0.0};
  const NoiseChoice held = choose_noise(oscillator(), options, captures, without_given(search, given));
  CHECK(held.velocity == 0.07);
  CHECK(held.drift == 0.0);
  CHECK(held.spread > 0.0);
}

TEST_CASE("noise of velocities or of rates is refused for a model without such a state") {
  const TemporaryDirectory files;
  const auto model =
      files.put("decay.toml",
                "name = \"decay\"\n[states]\nx = { initial = 2, unit = \"m\" }\n[parameters]\nk = "
                "{ unit = \"1/s\", above = 0 }\n[rates]\nx = \"-k*x\"\n");
  FitResult fitted = fit_of_clusters(2, 1.0);
  fitted.model = "decay";
  FollowRequest request{.source = model.string(), .fit = files.put("fit.json", fit_json(fitted))};
  request.track = files.path() / "none.csv";
  const auto refusal = [&](const GivenNoise& noise) {
    request.noise = noise;
    return error_of<ArgumentError>([&] { follow_files(request); });
  };
  CHECK(refusal({.velocity = 0.1}) ==
        "the noise of velocities (--velocity-noise) is 0.1 m/s per root of a second, but \"decay\" has no "
        "state in m/s; none was expected");
  CHECK(refusal({.rate = 3.0}) ==
        "the noise of rates (--rate-noise) is 3 rad/s per root of a second, but \"decay\" has no state in "
        "rad/s; none was expected");
  CHECK_THAT(refusal({.velocity = 0.0, .rate = 0.0}), Contains("none.csv"));
}

TEST_CASE("noise goes to states by their units, however these are written") {
  const auto model = models::equation_model(
      {.name = "slowing",
       .states = {{.name = "v", .unit = "m s^-1"}, {.name = "w", .unit = "s^-1"}, {.name = "x", .unit = "m"}},
       .parameters = {{.name = "k", .unit = "1/s"}},
       .rates = {"-k*v", "-k*w", "v"}});
  CHECK(has_noise(model->info(), &ModelNoise::velocity));
  CHECK(has_noise(model->info(), &ModelNoise::rate));
  CHECK(has_noise(oscillator()->info(), &ModelNoise::velocity));
  CHECK_FALSE(has_noise(oscillator()->info(), &ModelNoise::rate));
}

TEST_CASE("a followed motion tells of no noise that its model lacks, and which of it was given") {
  FollowReport report{.noise_was_chosen = true, .given = {.drift = 0.02}};
  report.noise.drift = 0.02;
  CHECK_THAT(follow_text(report),
             Contains("noise of frames times 1, of velocities 0.3 m/s and of rates 3 rad/s per root of a "
                      "second; coefficients differ by 0.1 and drift by 0.02 (given) per root of a second: "
                      "chosen on captures to train"));
  report.has_rates = false;
  CHECK_THAT(follow_text(report),
             Contains("times 1, of velocities 0.3 m/s per root of a second; coefficients"));
  report.has_velocities = false;
  CHECK_THAT(follow_text(report), Contains("noise of frames times 1; coefficients differ"));
}
