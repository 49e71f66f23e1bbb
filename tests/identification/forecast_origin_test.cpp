/// Forecasts of captures: nothing that comes after their origin counts, and training makes distributions of them.
#include <algorithm>
#include <random>
#include <string>

#include <catch2/catch.hpp>

#include "files.h"
#include "predicted_motions.h"
#include "samara/identification/fit/capture_prediction.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/prediction_config.h"
#include "samara/identification/fit/prediction_scores.h"

using namespace samara::identification;
using namespace predicted_motions;

namespace {

constexpr double kSpan = 0.6, kAhead = 0.3;
constexpr int kBump = 12;  ///< the last frame of the span that is seen

/// A table of a braked motion at 20 Hz whose last frame before the origin lies 5 mm off; what follows lies on the
/// motion, or goes on from there, so that cleaning all of it calls that frame wrong or right.
std::string table(bool goes_on) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, 1e-4);
  std::string text = "t[s],x[m]\n";
  for (int k = 0; k < 31; ++k) {
    const double t = 0.05 * k;
    double x = BrakedFamily::depth(1.4, 0.9, t) + noise(random);
    if (k == kBump || (goes_on && k > kBump)) x += 5e-3;
    text += fmt::format("{},{:.7f}\n", t, x);
  }
  return text;
}

Capture read(const TestFiles& files, const std::string& name, bool goes_on) {
  files.put(name + ".csv", table(goes_on));
  const auto sidecar =
      files.put(name + ".toml", fmt::format("file = \"{}.csv\"\n[columns]\n"
                                            "\"t[s]\" = {{ quantity = \"t\", unit = \"s\" }}\n"
                                            "\"x[m]\" = {{ quantity = \"x\", unit = \"m\" }}\n"
                                            "[clean]\nframe_grid = true\noutliers = 5\n"
                                            "bandwidth = \"0.3 s\"\n",
                                            name));
  return read_captures(sidecar).at(0);
}

}  // namespace

TEST_CASE("frames after the origin of a forecast change no bit of it, from file to prediction") {
  const TestFiles files;
  const Capture back = read(files, "back", false), on = read(files, "on", true);
  // Cleaned with all frames they differ in what was seen: this is what may not show.
  const auto left_out = [](const Capture& capture) {
    std::vector<int> frames;
    for (int k = 0; k <= kBump; ++k) {
      if (std::isnan(capture.channels[0].values[k])) frames.push_back(k);
    }
    return frames;
  };
  CAPTURE(left_out(back), left_out(on));
  REQUIRE(left_out(back) == std::vector<int>{kBump});
  REQUIRE(left_out(on) != left_out(back));

  const BrakedFamily family;
  FitOptions options = plain();
  options.unknowns.fixed = {{"k", 1.4}};
  options.compared.span = kSpan;
  const PredictedOutputs outputs{.outputs = {{"x", "m"}}};
  const PredictionOptions prediction{.span = kSpan, .ahead = kAhead};
  const auto bits_of = [&](const Capture& capture) {
    const CapturePrediction one = predict_capture(family, capture, outputs, options, prediction);
    REQUIRE(one.lack.empty());
    REQUIRE(one.failure.empty());
    Eigen::MatrixXd all(one.times.size(), 1 + std::ssize(all_baselines()));
    all.col(0) = one.model;
    for (Eigen::Index b = 0; b + 1 < all.cols(); ++b)
      all.col(b + 1) = predict(all_baselines()[static_cast<std::size_t>(b)], one.seen, one.times);
    return all.array().isNaN().select(-1.0, all).eval();
  };
  CHECK(bits_of(back) == bits_of(on));
  // Spans along a capture begin later, and end at the same origin.
  const auto span_of = [](const Capture& capture) { return spans(capture, kSpan + kAhead, 0.05).at(1); };
  const Capture later = span_of(back);
  CHECK(later.shift == Approx(0.05));
  const PredictionOptions shorter{.span = kSpan - 0.05, .ahead = kAhead};
  const auto model_of = [&](const Capture& capture) {
    FitOptions own = options;
    own.compared.span = shorter.span;
    return predict_capture(family, capture, outputs, own, shorter).model;
  };
  CHECK(model_of(later) == model_of(span_of(on)));
  // What is left of a capture that nobody cleaned is the same frames.
  Capture plainly = back;
  plainly.before_cleaning.reset();
  CHECK(known_at(plainly, kSpan).frame_count() == kBump + 1);
  CHECK(std::isnan(known_at(plainly, kSpan).channels[0].values[kBump]));
  CHECK_THROWS_AS(known_at(back, 0.1), samara::Error);  // three frames are no grid
}

TEST_CASE("with a mixture forecasts have distributions, of all captures and of folds") {
  const BrakedFamily family;
  PredictionOptions prediction{.span = 0.6, .ahead = 0.5, .mixture = true};
  const std::vector<Capture> training = braked(0, 9, 2e-3), left_out = braked(9, 12, 2e-3);
  FitResult fitted = fit(family, training, plain());
  add_predictions(family, left_out, plain(), prediction, fitted, training);
  const std::string ahead = "position, 0.5 s ahead";
  const PredictionScore& model = of(fitted.predictions, "model", ahead);
  const PredictionScore& mixture = of(fitted.predictions, "mixture", ahead);
  const PredictionScore& line = of(fitted.predictions, "straight line", ahead);
  CHECK(mixture.count == 12);
  CHECK(mixture.median < 2.0 * model.median);
  CHECK(model.crps < 0.5 * line.crps);
  CHECK(mixture.crps < 0.5 * line.crps);
  CHECK(of(fitted.predictions, "mixture", "position, up to 0.5 s ahead").coverage90 > 0.7);
  CHECK(model.behind_best < 0.0);
  CHECK(model.behind_best_error < -0.5 * model.behind_best);
  const auto says_shares = [](const FitResult& result) {
    return std::ranges::any_of(result.warnings.sentences(), [](const std::string& sentence) {
      return sentence.starts_with("the mixture of position, 0.5 s ahead: ");
    });
  };
  CHECK(says_shares(fitted));
  // Without it nothing is said of spread.
  prediction.mixture = false;
  CHECK(std::isnan(of(predict_left_out(family, fitted, left_out, plain(), prediction), "model", ahead).crps));
  prediction.mixture = true;

  FitResult of_folds = fit(family, training, plain());
  cross_validate(family, training, plain(), prediction, {.count = 3}, of_folds);
  CHECK(of(of_folds.predictions, "mixture", ahead).count == 9);
  CHECK(of(of_folds.predictions, "model", ahead).crps > 0.0);
  CHECK_THROWS_WITH(check_folds(std::span(training).first(2), plain(), prediction, {.count = 2}),
                    Catch::Contains("there is 1 cluster of them; two or more were expected"));
  CHECK_THROWS_WITH(add_predictions(family, left_out, plain(), prediction, fitted),
                    Catch::Contains("there are 0 clusters"));
  CHECK(parse_prediction_config("[prediction]\nmixture = true\n", "fit.toml").mixture);
}

TEST_CASE("medians of two predictors of the same captures differ by less than each of them scatters") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> hard(0.5, 2.0);
  PredictionTally ours("model", "position"), theirs("straight line", "position");
  for (int cluster = 0; cluster < 40; ++cluster) {
    const double size = hard(random);
    ours.add({size, 1.1 * size}, cluster);
    theirs.add({2.0 * size, 2.2 * size}, cluster);
  }
  const auto behind = ours.behind(theirs);
  CHECK(behind.value == Approx(-ours.score().median));
  CHECK(behind.error > 0.01 * ours.score().median);
  CHECK(behind.error < 0.2 * ours.score().median);
  CHECK(ours.behind(ours).error == Approx(0.0).margin(1e-15));
  PredictionTally single("model", "position");
  single.add({1.0, 2.0});
  CHECK(std::isnan(single.behind(single).error));
}
