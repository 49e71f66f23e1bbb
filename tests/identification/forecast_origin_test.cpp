/// Forecasts of captures: nothing that comes after their origin counts, and training makes distributions of them.
#include <algorithm>
#include <random>
#include <string>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "files.h"
#include "predicted_motions.h"
#include "samara/base/streams.h"
#include "samara/identification/fit/capture_prediction.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/motion_forecasts.h"
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

Capture read(const TemporaryDirectory& files, const std::string& name, bool goes_on) {
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

FitOptions held_drag() {
  FitOptions options = plain();
  options.unknowns.fixed = {{"k", 1.4}};
  options.compared.span = kSpan;
  return options;
}

}  // namespace

TEST_CASE("frames after the origin of a forecast change no bit of it, from file to prediction") {
  const TemporaryDirectory files;
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

namespace {

/// A forecast of a place in space with all that shows of it, at horizons of its own.
/// @param kicked times the acceleration after the origin that nothing before it shows
CapturePrediction made(int cluster, const std::vector<double>& ahead, double drift, double model_error,
                       samara::Stream& stream, double kicked = 1.0) {
  constexpr int kFrames = 20;
  CapturePrediction one{.motion = fmt::format("{}", cluster), .cluster = cluster};
  one.seen.times = Eigen::VectorXd::LinSpaced(kFrames, 0.0, 0.01 * (kFrames - 1));
  const Eigen::RowVector3d velocity(stream.normal(), stream.normal(), stream.normal());
  const Eigen::RowVector3d bend(drift * stream.normal(), drift * stream.normal(), drift * stream.normal());
  const Eigen::RowVector3d kick(drift * stream.normal(), drift * stream.normal(), drift * stream.normal());
  const double last = one.seen.times[kFrames - 1];
  const auto place = [&](double t) {
    const double since = std::max(0.0, t - last);  // which only the model foresees
    return Eigen::RowVector3d(velocity * t + bend * t * t + kicked * kick * since * since);
  };
  one.seen.positions.resize(kFrames, 3);
  for (int k = 0; k < kFrames; ++k) {
    one.seen.positions.row(k) = place(one.seen.times[k]);
    for (int c = 0; c < 3; ++c) one.seen.positions(k, c) += 1e-5 * stream.normal();
  }
  const auto count = std::ssize(ahead);
  one.times.resize(count);
  one.truth.resize(count, 3);
  for (Eigen::Index k = 0; k < count; ++k) {
    one.times[k] = one.seen.times[kFrames - 1] + ahead[static_cast<std::size_t>(k)];
    one.truth.row(k) = place(one.times[k]);
  }
  one.model = one.truth;
  // Near, the model is far off; later it is right.
  for (int c = 0; c < 3; ++c) one.model(0, c) += model_error * stream.normal();
  return one;
}

const std::vector<Quantity> kPlace = {
    {.name = "position", .unit = "m", .columns = {0, 1, 2}, .components = {.level = {0, 1}}, .up = 2}};

Eigen::RowVectorXd mean_of(const std::vector<SaidForecast>& said, const std::string& predictor) {
  const auto found = std::ranges::find(said, predictor, &SaidForecast::predictor);
  REQUIRE(found != said.end());
  return found->mean;
}

}  // namespace

TEST_CASE("shares of each horizon are those that its own training frames show") {
  samara::Stream stream(28, 0);
  const std::vector<double> ahead = {0.02, 0.3};
  std::vector<CapturePrediction> training;
  for (int k = 0; k < 60; ++k) training.push_back(made(k, ahead, 5.0, 0.5, stream));
  // One of them goes further; too few to learn from.
  training.push_back(made(60, {0.02, 0.3, 0.6}, 5.0, 0.5, stream));
  const MotionForecasts trained(kPlace, training, {.span = 0.2, .ahead = 0.3});
  double near = 0.0, near_model = 0.0, far = 0.0, far_line = 0.0;
  for (int k = 100; k < 140; ++k) {
    const CapturePrediction one = made(k, ahead, 5.0, 0.5, stream);
    const auto here = trained.say(0, one, 0), there = trained.say(0, one, 1);
    near += (mean_of(here, "mixture") - one.truth.row(0)).norm();
    near_model += (mean_of(here, "model") - one.truth.row(0)).norm();
    far += (mean_of(there, "mixture") - one.truth.row(1)).norm();
    far_line += (mean_of(there, "straight line") - one.truth.row(1)).norm();
  }
  CHECK(near < 0.02 * near_model);  // baselines alone
  CHECK(far < 0.02 * far_line);     // the model alone
  CHECK_THAT(trained.shares(0), Catch::Contains("0.3 s ahead") && Catch::Contains("model"));
  // A horizon that one training frame shows is forecast as the nearest one: by the model.
  const CapturePrediction further = made(200, {0.02, 0.3, 0.6, 0.6}, 5.0, 0.0, stream);
  CHECK((mean_of(trained.say(0, further, 2), "mixture") - further.truth.row(2)).norm() < 0.05);
}

TEST_CASE("of hundreds of horizons dozens are trained, and between them forecasts are as good") {
  samara::Stream stream(28, 1);
  std::vector<double> ahead;
  for (int k = 1; k <= 200; ++k) ahead.push_back(0.01 * k);
  std::vector<CapturePrediction> training;
  for (int k = 0; k < 20; ++k) training.push_back(made(k, ahead, 1.0, 0.0, stream, 0.0));
  const MotionForecasts trained(kPlace, training, {.span = 0.2, .ahead = 2.0});
  const std::vector<double> horizons = trained.horizons(0);
  CHECK(horizons.size() < 40);
  CHECK(horizons.front() == Approx(0.01));
  CHECK(horizons.back() == Approx(2.0));
  const auto is_trained = [&](double at) {
    return std::ranges::any_of(horizons, [&](double one) { return std::abs(one - at) < 1e-6; });
  };
  // Errors of the autoregression, and deviations of the mixture.
  std::vector<double> errors(ahead.size(), 0.0), deviations(ahead.size(), 0.0);
  for (int k = 100; k < 110; ++k) {
    const CapturePrediction one = made(k, ahead, 1.0, 0.0, stream, 0.0);
    for (std::size_t frame = 0; frame < ahead.size(); ++frame) {
      const auto row = static_cast<Eigen::Index>(frame);
      const std::vector<SaidForecast> said = trained.say(0, one, row);
      errors[frame] += (mean_of(said, kAutoregression) - one.truth.row(row)).norm();
      REQUIRE(said.back().parts.size() == 3);
      deviations[frame] += said.back().parts[0].deviations.mean();
    }
  }
  std::size_t near = 0;
  for (std::size_t frame = 0; frame < ahead.size(); ++frame) {
    if (is_trained(ahead[frame])) {
      near = frame;
      continue;
    }
    std::size_t far = frame;
    while (!is_trained(ahead[far])) ++far;
    INFO("frame " << frame << " between " << near << " and " << far);
    // Motions are parabolas: what is interpolated adds nothing to the errors of both sides.
    CHECK(errors[frame] < 1.01 * std::max(errors[near], errors[far]));
    CHECK(deviations[frame] <= 1.001 * std::max(deviations[near], deviations[far]));
    CHECK(deviations[frame] >= 0.999 * std::min(deviations[near], deviations[far]));
  }
}

TEST_CASE("a mixture that training taught nothing, or of nearer frames alone, is named with the reason") {
  samara::Stream stream(28, 2);
  const std::vector<double> ahead = {0.02, 0.3};
  std::vector<CapturePrediction> training;
  for (int k = 0; k < 12; ++k) training.push_back(made(k, ahead, 5.0, 0.5, stream));
  const PredictionOptions prediction{.span = 0.2, .ahead = 0.3};
  CHECK(MotionForecasts(kPlace, training, prediction).lacks(0.3).empty());
  const std::vector<std::string> nearer = MotionForecasts(kPlace, training, prediction).lacks(0.6);
  REQUIRE(nearer.size() == 1);
  CHECK_THAT(nearer[0], Catch::Contains("the mixture of position has learned 0.3 s ahead at most") &&
                            Catch::Contains("asked 0.6 s ahead"));
  // Its shares are those of the farthest frames that taught some, whatever is asked.
  CHECK_THAT(MotionForecasts(kPlace, training, {.span = 0.2, .ahead = 10.0}).shares(0),
             Catch::StartsWith("the mixture of position, 0.3 s ahead: "));
  CHECK_THAT(MotionForecasts(kPlace, training, prediction).shares(0),
             Catch::StartsWith("the mixture of position, 0.3 s ahead: "));
  const auto lacks_of = [&](std::size_t count) {
    return MotionForecasts(kPlace, std::span(training).first(count), prediction).lacks(0.3).at(0);
  };
  CHECK_THAT(lacks_of(0), Catch::Contains("the mixture of position says nothing"));
  CHECK_THAT(lacks_of(1), Catch::Contains("the mixture of position has no bands"));
  // Two show both horizons, two more the nearer one: it has bands.
  std::vector<CapturePrediction> uneven = {training[0], training[1]};
  for (int k = 2; k < 4; ++k) uneven.push_back(made(k, {0.02}, 5.0, 0.5, stream));
  CHECK_THAT(MotionForecasts(kPlace, uneven, prediction).lacks(0.3).at(0),
             Catch::Contains("the mixture of position has learned 0.02 s ahead at most"));

  // Captures of the fit that end where those left out are no longer seen.
  const BrakedFamily family;
  const std::vector<Capture> whole = braked(0, 6, 2e-3), left_out = braked(9, 3, 2e-3);
  std::vector<Capture> seen;
  for (const Capture& capture : whole) seen.push_back(known_at(capture, kSpan));
  FitResult fitted = fit(family, seen, plain());
  add_predictions(family, left_out, plain(), {.span = kSpan, .ahead = kAhead, .mixture = true}, fitted, seen);
  const auto says = [](const FitResult& result) {
    return std::ranges::count_if(result.warnings.sentences(), [](const std::string& sentence) {
      return sentence.starts_with("the mixture of position says nothing");
    });
  };
  CHECK(says(fitted) == 1);
}

TEST_CASE("no later frame changes a bit of what any predictor says, mixtures and distributions among them") {
  const TemporaryDirectory files;
  const BrakedFamily family;
  const FitOptions options = held_drag();
  const PredictionOptions prediction{.span = kSpan, .ahead = kAhead};
  const PredictedOutputs outputs{.outputs = {{"x", "m"}}};
  std::vector<CapturePrediction> training;
  for (const Capture& capture : braked(0, 9, 2e-3)) {
    training.push_back(predict_capture(family, capture, outputs, options, prediction));
    training.back().cluster = static_cast<int>(training.size());
  }
  std::vector<Quantity> compared = quantities(family, outputs, options);
  REQUIRE(compared.size() == 1);
  compared[0].up = 0;  // so that the point with drag says something
  const MotionForecasts trained(compared, training, prediction);
  const auto said_of = [&](const Capture& capture) {
    const CapturePrediction one = predict_capture(family, capture, outputs, options, prediction);
    REQUIRE(one.failure.empty());
    std::vector<double> numbers;
    for (Eigen::Index frame = 0; frame < one.times.size(); ++frame) {
      for (const SaidForecast& said : trained.say(0, one, frame)) {
        if (!std::isfinite(said.mean[0])) continue;
        numbers.push_back(said.mean[0]);
        for (const NormalMixture& part : said.parts) {
          for (const Eigen::VectorXd& of : {part.weights, part.means, part.deviations})
            numbers.insert(numbers.end(), of.begin(), of.end());
        }
      }
    }
    return numbers;
  };
  const std::vector<double> back = said_of(read(files, "back", false));
  CHECK(back.size() > 200);
  CHECK(back == said_of(read(files, "on", true)));
  // Wild and missing frames after the origin, without cleaning.
  Capture plainly = read(files, "back", false), wild = plainly;
  plainly.before_cleaning.reset();
  wild.before_cleaning.reset();
  for (Eigen::Index k = kBump + 1; k < wild.times.size(); ++k)
    wild.channels[0].values[k] = k % 3 == 0 ? std::nan("") : 1e3 * static_cast<double>(k);
  CHECK(said_of(plainly) == said_of(wild));
}

TEST_CASE("spans that only teach make the autoregression better, and change no bit of model and baselines") {
  const BrakedFamily family;
  const FitOptions options = held_drag();
  const PredictionOptions prediction{.span = kSpan, .ahead = kAhead};
  const PredictedOutputs outputs{.outputs = {{"x", "m"}}};
  std::vector<CapturePrediction> asked, all;
  const std::vector<Capture> captures = braked(0, 40, 2e-3);
  for (std::size_t k = 0; k < captures.size(); ++k) {
    const bool asks_model = k < 6;
    CapturePrediction one = predict_capture(family, captures[k], outputs, options, prediction, asks_model);
    one.cluster = static_cast<int>(k);
    CHECK((one.model.size() > 0) == asks_model);
    if (asks_model) asked.push_back(one);
    all.push_back(std::move(one));
  }
  const std::vector<Quantity> compared = quantities(family, outputs, options);
  const MotionForecasts by_few(compared, asked, prediction), by_all(compared, all, prediction);
  double error_of_few = 0.0, error_of_all = 0.0;
  for (const Capture& capture : braked(40, 60, 2e-3)) {
    const CapturePrediction one = predict_capture(family, capture, outputs, options, prediction);
    const Eigen::Index last = one.times.size() - 1;
    const std::vector<SaidForecast> few = by_few.say(0, one, last), many = by_all.say(0, one, last);
    REQUIRE(few.size() == many.size());
    for (std::size_t m = 0; m < few.size(); ++m) {
      const std::string& predictor = few[m].predictor;
      INFO(predictor);
      REQUIRE(many[m].predictor == predictor);
      if (predictor == kAutoregression) {
        error_of_few += std::abs(few[m].mean[0] - one.truth(last, 0));
        error_of_all += std::abs(many[m].mean[0] - one.truth(last, 0));
      } else if (predictor != kMixture && std::isfinite(few[m].mean[0])) {
        CHECK(many[m].mean == few[m].mean);
        REQUIRE(many[m].parts.size() == few[m].parts.size());
        for (std::size_t c = 0; c < few[m].parts.size(); ++c)
          CHECK(many[m].parts[c].deviations == few[m].parts[c].deviations);
      }
    }
  }
  CHECK(error_of_all < error_of_few);
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
  CHECK_THROWS_WITH(check_folds(family, std::span(training).first(2), plain(), prediction, {.count = 2}),
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
