/// Noise levels that the fit finds itself.
#include <algorithm>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/prediction.h"
#include "samara/identification/problem/fit_config.h"
#include "samara/models/laws/registry.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;

namespace {

/// x = v0 (1 - exp(-k t))/k and its rate.
class BrakedWithRate final : public samara::models::TrajectoryFamily {
 public:
  BrakedWithRate() {
    info_ = BrakedFamily().info();
    info_.outputs.push_back({"v", "m/s"});
  }
  const samara::models::FamilyInfo& info() const override { return info_; }
  std::unique_ptr<samara::models::TrajectorySource> at(
      const std::vector<double>& times, const std::vector<std::string>& outputs) const override {
    return std::make_unique<Source>(times, outputs);
  }

 private:
  struct Source final : samara::models::TrajectorySource {
    Source(const std::vector<double>& at_times, const std::vector<std::string>& names)
        : times(at_times), outputs(names) {}
    samara::models::TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                               Eigen::MatrixXd* derivatives) override {
      const auto count = static_cast<Eigen::Index>(outputs.size());
      for (Eigen::Index row = 0; row < values.rows(); ++row) {
        const double t = times[static_cast<std::size_t>(row)];
        const double kt = q[0] * t;
        for (Eigen::Index o = 0; o < count; ++o) {
          const bool is_rate = outputs[static_cast<std::size_t>(o)] == "v";
          values(row, o) = is_rate ? q[1] * std::exp(-kt) : BrakedFamily::depth(q[0], q[1], t);
          if (!derivatives) continue;
          (*derivatives)(row, o) = is_rate ? -t * q[1] * std::exp(-kt)
                                           : q[1] * (kt * std::exp(-kt) + std::expm1(-kt)) / (q[0] * q[0]);
          (*derivatives)(row, o + count) = is_rate ? std::exp(-kt) : BrakedFamily::depth(q[0], 1.0, t);
        }
      }
      return {};
    }
    std::vector<double> times;
    std::vector<std::string> outputs;
  };
  samara::models::FamilyInfo info_;
};

constexpr double kRate = 1.4;
constexpr double kNoiseX = 3e-3, kNoiseV = 0.05;

std::vector<Capture> braked(std::uint64_t seed, int captures = 4, int frames = 60) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Capture> joined_sentences;
  for (int c = 0; c < captures; ++c) {
    const double v0 = 0.8 + 0.2 * c;
    const std::vector<double> times = even_times(frames, 1.5);
    joined_sentences.push_back(
        make_capture(fmt::format("{}", c), times, BrakedFamily::depths(kRate, v0, times)));
    Capture& capture = joined_sentences.back();
    capture.channels.push_back({"v", "m/s", v0 * (-kRate * capture.times.array()).exp().matrix()});
    for (double& value : capture.channels[0].values) value += kNoiseX * normal(random);
    for (double& value : capture.channels[1].values) value += kNoiseV * normal(random);
  }
  return joined_sentences;
}

FitOptions estimated(LossKind loss) {
  FitOptions options;
  options.loss.kind = loss;
  options.noise.estimated = true;
  options.starts.count = 1;
  return options;
}

}  // namespace

TEST_CASE("two outputs have their noise levels found, with every loss") {
  const std::vector<Capture> captures = braked(1, 6, 100);
  for (const LossKind loss : {LossKind::none, LossKind::huber, LossKind::soft_l1, LossKind::cauchy}) {
    INFO(to_string(loss));
    const FitResult result = fit(BrakedWithRate(), captures, estimated(loss));
    CHECK(result.status == samara::Termination::converged);
    REQUIRE(result.noise.size() == 2);
    CHECK(result.noise[0].outputs == std::vector<std::string>{"x"});
    CHECK(result.noise[1].unit == "m/s");
    // 600 values: a level has a standard error of 2.9 % by squares, a little more by robust losses.
    CHECK(result.noise[0].value == Approx(kNoiseX).epsilon(0.1));
    CHECK(result.noise[1].value == Approx(kNoiseV).epsilon(0.1));
    CHECK(result.noise[0].standard_error() == Approx(0.029 * kNoiseX).epsilon(0.15));
    CHECK(result.noise_rounds >= 1);
    CHECK(result.noise_rounds <= 5);
    // Less one coefficient, six starts and six offsets.
    CHECK(result.noise[0].degrees_of_freedom + result.noise[1].degrees_of_freedom ==
          Approx(1200.0 - 13.0).epsilon(1e-6));
  }
}

TEST_CASE("what is known of a combination of coefficients leaves its degree of freedom to the noise levels") {
  FitOptions options = estimated(LossKind::none);
  const std::vector<Capture> captures = braked(5);
  const auto freedom = [&] {
    const FitResult result = fit(BrakedWithRate(), captures, options);
    return result.noise[0].degrees_of_freedom + result.noise[1].degrees_of_freedom;
  };
  const double without = freedom();
  options.priors.combinations = {{.weights = {{"k", 1.0}}, .mean = kRate, .deviation = 1e-7}};
  CHECK(freedom() == Approx(without + 1.0).margin(1e-3));
}

TEST_CASE("from where the noise levels start does not matter") {
  const std::vector<Capture> captures = braked(2);
  FitOptions options = estimated(LossKind::huber);
  const FitResult free = fit(BrakedWithRate(), captures, options);
  for (const auto& [x, v] : {std::pair{1e-4, 5.0}, std::pair{0.3, 1e-3}}) {
    options.loss.scales = {{"x", x}, {"v", v}};
    const FitResult result = fit(BrakedWithRate(), captures, options);
    INFO(x << " m, " << v << " m/s");
    // Rounds end below 1 %.
    CHECK(result.noise[0].value == Approx(free.noise[0].value).epsilon(0.02));
    CHECK(result.noise[1].value == Approx(free.noise[1].value).epsilon(0.02));
    CHECK(result.coefficients[0].value ==
          Approx(free.coefficients[0].value).margin(0.05 * *free.coefficients[0].naive_standard_error));
  }
}

TEST_CASE("outliers do not swell the level of a robust loss") {
  std::vector<Capture> captures = braked(3);
  for (Capture& capture : captures) capture.channels[0].values({7, 23, 41}).array() += 0.1;
  // A twentieth of the frames off by 30 deviations: the bounded chi takes them for frames at its bound, which
  // adds a twentieth to a sum of 0.71 n/1.8 per frame: 9 % of the level, and the noise of the level itself.
  const FitResult robust = fit(BrakedWithRate(), captures, estimated(LossKind::huber));
  CHECK(robust.noise[0].value == Approx(kNoiseX).epsilon(0.2));
  const FitResult plain = fit(BrakedWithRate(), captures, estimated(LossKind::none));
  CHECK(plain.noise[0].value > 5.0 * kNoiseX);
}

TEST_CASE("intervals cover with levels that were estimated") {
  constexpr int kSeeds = 200;  // 0.4 s
  int covered = 0;
  double bias = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const FitResult result = fit(BrakedWithRate(), braked(static_cast<std::uint64_t>(100 + seed), 2, 25),
                                 estimated(LossKind::none));
    const Coefficient& k = result.coefficients[0];
    covered += std::abs(k.value - kRate) < 1.96 * k.naive_standard_error.value() ? 1 : 0;
    bias += std::log(result.noise[1].value / kNoiseV) / kSeeds;
  }
  // Binomial with p = 0.95: 190 +- 3.1.
  CHECK(covered >= 190 - 10);
  CHECK(covered <= 199);
  // 50 values: each level scatters by 10 %, their mean by 0.7 %, and the logarithm is low by 1/(2 * 48).
  CHECK(std::abs(bias + 0.01) < 0.03);
}

TEST_CASE("outputs may share a level, and others keep their scale") {
  std::vector<Capture> captures = braked(4);
  FitOptions options = estimated(LossKind::none);
  options.noise.levels = {{"v", "rates"}};
  const FitResult one = fit(BrakedWithRate(), captures, options);
  REQUIRE(one.noise.size() == 1);
  CHECK(one.noise[0].outputs == std::vector<std::string>{"v"});
  options.noise.levels = {{"v", "joined_sentences"}, {"x", "joined_sentences"}};
  CHECK_THROWS_WITH(fit(BrakedWithRate(), captures, options), Contains("outputs of one unit were expected"));
  options.noise.levels = {{"x", "a"}, {"v", "b"}, {"w", "c"}};
  CHECK_THROWS_WITH(fit(BrakedWithRate(), captures, options),
                    Contains("\"w\" is not among what is compared"));
}

TEST_CASE("an output that is met exactly, or has too few frames, is said to have no level") {
  std::vector<Capture> captures = braked(5, 1);
  captures[0].channels[1].values.setConstant(std::nan(""));
  captures[0].channels[1].values[0] = 0.8;
  captures[0].channels[1].values[30] = 0.3;
  FitOptions options = estimated(LossKind::none);
  options.loss.scales["v"] = 1e-4;
  const FitResult few = fit(BrakedWithRate(), captures, options);
  CHECK_THAT(text_of(few.warnings),
             Contains("v has 2 values for the") && Contains("noise cannot be estimated"));
  CHECK_FALSE(few.noise[1].estimated);
  CHECK(few.noise[1].value == Approx(1e-4));
  CHECK(few.noise[0].estimated);

  const std::vector<double> times = even_times(30, 1.5);
  const std::vector exact = {make_capture("exact", times, BrakedFamily::depths(kRate, 1.0, times))};
  options = estimated(LossKind::none);
  const FitResult none = fit(BrakedFamily(), exact, options);
  CHECK(none.status == samara::Termination::converged);
  CHECK_THAT(text_of(none.warnings), Contains("the model meets x exactly"));
  CHECK_FALSE(none.noise[0].estimated);
}

TEST_CASE("a level that holds what the model misses is said to") {
  std::vector<Capture> captures = braked(6, 2);
  for (Capture& capture : captures) {
    capture.channels.pop_back();
    capture.channels[0].values.array() += 0.05 * (8.0 * capture.times.array()).sin();
  }
  const FitResult result = fit(BrakedFamily(), captures, estimated(LossKind::none));
  CHECK_THAT(text_of(result.warnings),
             Contains("the noise level of x") && Contains("most of it is what the model misses"));
}

TEST_CASE("captures left out are fitted with the levels that were found") {
  const std::vector<Capture> captures = braked(7, 3);
  const FitOptions options = estimated(LossKind::huber);
  const FitResult fitted = fit(BrakedWithRate(), captures, options);
  const auto scores =
      predict_left_out(BrakedWithRate(), fitted, braked(8, 3), options, {.span = 0.75, .ahead = 0.5});
  REQUIRE_FALSE(scores.empty());
  CHECK(scores[0].predictor == "model");
  // Within a few deviations of one frame.
  CHECK(scores[0].rms < 4.0 * kNoiseX);
}

TEST_CASE("a config asks for noise levels by a word or by a table") {
  const ConfigNames names = config_names(samara::models::find_model("falling_plate")->info());
  const auto read = [&](const std::string& text) { return parse_fit_config(text, "fit.toml", names).noise; };
  CHECK_FALSE(read("").estimated);
  CHECK(read("noise = \"estimated\"").estimated);
  CHECK(read("noise = \"estimated\"").levels.empty());
  const NoiseOptions noise =
      read("noise = { levels = { x = \"place\", y = \"place\", attitude = \"turn\" }, rounds = 4 }");
  CHECK(noise.estimated);
  CHECK(noise.rounds == 4);
  CHECK(noise.levels.at("y") == "place");
  CHECK_THROWS_WITH(read("noise = \"guessed\""), Contains("\"guessed\" means nothing here"));
  CHECK_THROWS_WITH(read("noise = { levels = { X = \"place\" } }"), Contains("X: unknown key"));
}
