/// Views of captures: named in a config, looked at by trained forecasts.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "closed_form_family.h"
#include "files.h"
#include "predicted_motions.h"
#include "samara/identification/fit/capture_prediction.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/motion_forecasts.h"
#include "samara/identification/fit/prediction_config.h"
#include "samara/identification/fit/prediction_scores.h"

using namespace samara::identification;
using namespace predicted_motions;
using Catch::Matchers::Contains;

namespace {

constexpr int kGlideSeen = 16, kGlideFrames = 21;
constexpr double kGlideInterval = 0.02, kGlideSpan = (kGlideSeen - 1) * kGlideInterval, kGlideAhead = 0.1;

/// Straight ways down from the origin.
class GlideFamily final : public ClosedFormFamily {
 public:
  GlideFamily()
      : ClosedFormFamily({.model = "straight",
                          .coordinates = {{"fall", "m/s", false, 0.05, 0.5},
                                          {"ux(0)", "m/s", true, -1.0, 1.0},
                                          {"uy(0)", "m/s", true, -1.0, 1.0}},
                          .outputs = {{"x", "m"}, {"y", "m"}, {"z", "m"}},
                          .translations = {"x", "y", "z"}},
                         [](std::span<const double> q, double t, auto& values, auto* derivatives) {
                           values << q[1] * t, q[2] * t, -q[0] * t;
                           if (derivatives) *derivatives << 0.0, 0.0, -t, t, 0.0, 0.0, 0.0, t, 0.0;
                         }) {}
};

/// A plate that glides faster from the last frame of the span on, by its tilt. Cameras show how much of that is along
/// either axis.
Capture glide(int number) {
  std::mt19937_64 random(static_cast<std::uint64_t>(number) + 1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double heading = 6.28 * uniform(random), speed = 0.1 + 0.1 * uniform(random),
               tilt = 0.2 + uniform(random);
  const Eigen::Vector2d along(std::cos(heading), std::sin(heading));
  const Eigen::VectorXd t =
      Eigen::VectorXd::LinSpaced(kGlideFrames, 0.0, (kGlideFrames - 1) * kGlideInterval);
  const Eigen::VectorXd faster = 0.2 * tilt * (t.array() - kGlideSpan).cwiseMax(0.0);
  Capture capture{.id = fmt::format("{}", number), .file = {}, .labels = {}, .times = t, .channels = {}};
  capture.channels = {{"x", "m", along[0] * (speed * t + faster)},
                      {"y", "m", along[1] * (speed * t + faster)},
                      {"z", "m", -0.2 * t - 0.5 * faster}};
  add_noise(capture, 1e-4, random);
  capture.channels.push_back({"area_1", "1", tilt * along[0] * along[0] * t});
  capture.channels.push_back({"area_2", "1", tilt * along[1] * along[1] * t});
  return capture;
}

std::vector<Capture> glides(int first, int count) {
  std::vector<Capture> captures;
  for (int k = first; k < first + count; ++k) captures.push_back(glide(k));
  return captures;
}

PredictionOptions options_of_views() {
  return {.span = kGlideSpan, .ahead = kGlideAhead, .mixture = true, .views = {{"area_1", "area_2"}}};
}

FitOptions held_glide() {
  FitOptions options = plain();
  options.unknowns.fixed = {{"fall", 0.2}};
  options.compared.span = kGlideSpan;
  return options;
}

const PredictedOutputs kGlidePlaces{.outputs = {{"x", "m"}, {"y", "m"}, {"z", "m"}}};

CapturePrediction predicted_glide(const Capture& capture, int cluster = -1) {
  CapturePrediction one =
      predict_capture(GlideFamily(), capture, kGlidePlaces, held_glide(), options_of_views());
  REQUIRE(one.lack.empty());
  REQUIRE(one.failure.empty());
  one.cluster = cluster;
  return one;
}

MotionForecasts trained_by_glides(const std::vector<Capture>& captures) {
  std::vector<CapturePrediction> training;
  for (const Capture& capture : captures)
    training.push_back(predicted_glide(capture, static_cast<int>(training.size())));
  return {quantities(GlideFamily(), kGlidePlaces, held_glide()), training, options_of_views()};
}

Eigen::RowVectorXd glide_said(const MotionForecasts& trained, const Capture& capture, Eigen::Index frame) {
  const std::vector<SaidForecast> said = trained.say(0, predicted_glide(capture), frame);
  const auto found = std::ranges::find(said, kAutoregression, &SaidForecast::predictor);
  REQUIRE(found != said.end());
  return found->mean;
}

/// As a caller of the library makes it.
TrainingMoment glide_moment(const Capture& capture, int cluster) {
  SeenMotion seen{.times = capture.times.head(kGlideSeen), .up = 2};
  seen.positions.resize(kGlideSeen, 3);
  Eigen::RowVector3d next;
  for (int c = 0; c < 3; ++c) {
    const Eigen::VectorXd& all = capture.channels[static_cast<std::size_t>(c)].values;
    seen.positions.col(c) = all.head(kGlideSeen);
    next[c] = all[kGlideFrames - 1];
  }
  seen.views.resize(kGlideSeen, 1);
  seen.views.real() = capture.channel("area_1").values.head(kGlideSeen);
  seen.views.imag() = capture.channel("area_2").values.head(kGlideSeen);
  return {.cluster = cluster, .seen = std::move(seen), .next = next};
}

std::string views_error(const std::string& lines) {
  return error_of<samara::InputError>([&] { parse_prediction_config("[prediction]\n" + lines, "fit.toml"); });
}

}  // namespace

TEST_CASE("a config names pairs of channels as views, and says where what it names is none") {
  const PredictionConfig config = parse_prediction_config(
      "[prediction]\nmixture = true\nviews = [[\"aspect_1\", \"aspect_2\"], [\"area_1\", \"area_2\"]]\n",
      "fit.toml");
  CHECK(config.views == std::vector<ViewPair>{{"aspect_1", "aspect_2"}, {"area_1", "area_2"}});
  CHECK(parse_prediction_config("[prediction]\nmixture = true\n", "fit.toml").views.empty());
  const auto error = [](const std::string& views) {
    return views_error("mixture = true\nviews = " + views + "\n");
  };
  const auto at = [](const std::string& sentence) {
    return Catch::StartsWith("fit.toml:3: [prediction] views: " + sentence);
  };
  CHECK_THAT(error("\"area_1\""), at("expected an array of arrays of strings, found"));
  CHECK_THAT(error("[\"area_1\", \"area_2\"]"), at("element 0: expected an array of strings, found"));
  CHECK_THAT(error("[[\"a\", \"b\"], [\"area_1\", 2]]"),
             at("element 1: element 1: expected a string, found"));
  CHECK_THAT(error("[[\"a\", \"b\"], [\"area_1\"]]"), at("element 1: expected a pair of channels"));
  CHECK_THAT(error("[[\"a\", \"b\", \"c\"]]"), at("element 0: expected a pair of channels"));
  CHECK_THAT(error("[[\"a\", \"b\"], [\"a\", \"b\"]]"), at("the channel \"a\" is named twice"));
  CHECK_THAT(error("[[\"a\", \"a\"]]"), at("the channel \"a\" is named twice"));
  CHECK_THAT(error("[]"), at("the list is empty"));
  for (const char* mixture : {"", "mixture = false\n"}) {
    CHECK_THAT(views_error(std::string(mixture) + "views = [[\"a\", \"b\"]]\n"),
               Contains("[prediction] views: only trained forecasts look at views; `mixture = true`"));
  }
}

TEST_CASE("views that captures do not have, or that no quarter turn exchanges, are refused before a fit") {
  const GlideFamily family;
  std::vector<Capture> captures = glides(0, 6), left_out = glides(6, 2);
  const auto error = [&](const PredictionOptions& prediction) {
    const std::string of_folds = error_of<samara::ArgumentError>(
        [&] { check_folds(family, captures, plain(), prediction, {.count = 3}); });
    CHECK(error_of<samara::ArgumentError>(
              [&] { check_left_out(family, captures, left_out, plain(), prediction); }) == of_folds);
    return of_folds;
  };
  PredictionOptions prediction = options_of_views();
  CHECK(error(prediction) == "no exception");
  prediction.views = {{"area_1", "area_3"}};
  CHECK_THAT(error(prediction), Contains("prediction.views: capture \"0\" does not measure \"area_3\"") &&
                                    Contains("did you mean"));
  prediction = options_of_views();
  captures[4].channels.back().unit = "m^2";
  CHECK_THAT(error(prediction),
             Contains("of capture \"4\" \"area_1\" is in 1 and \"area_2\" in m^2; a pair of one unit"));
  captures = glides(0, 6);
  // Some of the captures: of the fit, and left out.
  left_out[1].channels.pop_back();
  const auto left_out_error = error_of<samara::ArgumentError>(
      [&] { check_left_out(family, captures, left_out, plain(), prediction); });
  CHECK_THAT(left_out_error, Contains("prediction.views: capture \"7\" does not measure \"area_2\""));
  FitResult fitted = fit(family, captures, plain());
  CHECK_THROWS_WITH(add_predictions(family, left_out, plain(), prediction, fitted, captures),
                    Contains("capture \"7\" does not measure \"area_2\""));
  captures[3].channels.pop_back();
  CHECK_THROWS_WITH(add_predictions(family, glides(6, 2), plain(), prediction, fitted, captures),
                    Contains("capture \"3\" does not measure \"area_2\""));

  const BrakedFamily line;
  std::vector<Capture> braking = braked(0, 6, 0.0);
  for (Capture& capture : braking) {
    for (const char* name : {"area_1", "area_2"}) capture.channels.push_back({name, "1", capture.times});
  }
  CHECK_THROWS_WITH(check_folds(line, braking, plain(), prediction, {.count = 3}),
                    Contains("prediction.views: ") && Contains("has no two level components"));
}

TEST_CASE("a forecast with views of captures is the one that the library makes of the same numbers") {
  const std::vector<Capture> captures = glides(0, 60);
  const MotionForecasts trained = trained_by_glides(captures);
  std::vector<TrainingMoment> moments;
  for (const Capture& capture : captures)
    moments.push_back(glide_moment(capture, static_cast<int>(moments.size())));
  const Autoregression autoregression = Autoregression::fit(moments, {.level = {0, 1}});
  REQUIRE(autoregression.turning().sees_views());
  CHECK_THAT(trained.shares(0), Catch::EndsWith("; the autoregression looks at views"));
  for (const Capture& capture : glides(100, 10)) {
    const Eigen::RowVectorXd said = glide_said(trained, capture, kGlideFrames - kGlideSeen - 1);
    CHECK((said - autoregression.predict(glide_moment(capture, -1).seen, {})).norm() < 1e-12);
    Capture exchanged = capture;
    std::swap(exchanged.channels[3].values, exchanged.channels[4].values);
    CHECK((glide_said(trained, exchanged, kGlideFrames - kGlideSeen - 1) - said).norm() > 1e-6);
  }
}

TEST_CASE("views of captures left out make forecasts better, and without them nothing is said of views") {
  const GlideFamily family;
  const std::vector<Capture> training = glides(0, 60), left_out = glides(100, 20);
  PredictionOptions prediction = options_of_views();
  const auto scored = [&] {
    FitResult fitted = fit(family, training, held_glide());
    add_predictions(family, left_out, held_glide(), prediction, fitted, training);
    return fitted;
  };
  const FitResult seeing = scored();
  prediction.views.clear();
  const FitResult blind = scored();
  const auto median = [](const FitResult& fitted, const std::string& predictor) {
    return of(fitted.predictions, predictor, "position, 0.1 s ahead").median;
  };
  CHECK(median(seeing, kAutoregression) < 0.5 * median(blind, kAutoregression));
  for (const char* predictor : {"model", "straight line", "point with drag"})
    CHECK(median(seeing, predictor) == median(blind, predictor));
  CHECK_THAT(text_of(seeing.warnings), Contains("; the autoregression looks at views"));
  CHECK_THAT(text_of(blind.warnings), !Contains("views"));
}

TEST_CASE("later frames change no bit of a forecast with views, also where cleaning looks at both sides") {
  const MotionForecasts trained = trained_by_glides(glides(0, 60));
  const auto means_of_three = [](Capture capture) {
    for (Channel& channel : capture.channels) {
      const Eigen::VectorXd all = channel.values;
      for (Eigen::Index k = 1; k + 1 < all.size(); ++k) channel.values[k] = all.segment(k - 1, 3).mean();
    }
    return capture;
  };
  const auto cleaned = [&](const Capture& raw) {
    Capture capture = means_of_three(raw);
    capture.before_cleaning = std::make_shared<BeforeCleaning>(raw, means_of_three, raw.times);
    return capture;
  };
  const Capture raw = glide(100);
  Capture altered = raw;
  for (std::size_t c = 3; c < altered.channels.size(); ++c) {
    for (Eigen::Index k = kGlideSeen; k < kGlideFrames; ++k)
      altered.channels[c].values[k] = k % 3 == 2 ? std::nan("") : 1e3 * static_cast<double>(k);
  }
  REQUIRE(cleaned(raw).channel("area_1").values[kGlideSeen - 1] !=
          cleaned(altered).channel("area_1").values[kGlideSeen - 1]);
  for (Eigen::Index frame = 0; frame < kGlideFrames - kGlideSeen; ++frame) {
    for (const bool cleans : {true, false}) {
      const auto said = trained.say(0, predicted_glide(cleans ? cleaned(raw) : raw), frame);
      const auto again = trained.say(0, predicted_glide(cleans ? cleaned(altered) : altered), frame);
      REQUIRE(said.size() == again.size());
      for (std::size_t p = 0; p < said.size(); ++p) {
        INFO(said[p].predictor);
        if (!said[p].mean.allFinite()) continue;
        CHECK(said[p].mean == again[p].mean);
        for (std::size_t c = 0; c < said[p].parts.size(); ++c) {
          CHECK(said[p].parts[c].means == again[p].parts[c].means);
          CHECK(said[p].parts[c].deviations == again[p].parts[c].deviations);
          CHECK(said[p].parts[c].weights == again[p].parts[c].weights);
        }
      }
    }
  }
}

TEST_CASE("frames that show no view are bridged, and a capture that shows none is forecast without views") {
  const MotionForecasts trained = trained_by_glides(glides(0, 60));
  constexpr Eigen::Index kGlideLast = kGlideFrames - kGlideSeen - 1;
  const Capture whole = glide(100);
  Capture gap = whole, hidden = whole;
  gap.channels[3].values.segment(5, 3).setConstant(std::nan(""));  // views grow evenly
  hidden.channels[3].values.setConstant(std::nan(""));
  const Eigen::RowVectorXd said = glide_said(trained, whole, kGlideLast),
                           unseen = glide_said(trained, hidden, kGlideLast);
  CHECK((glide_said(trained, gap, kGlideLast) - said).norm() < 1e-9);
  CHECK(unseen.allFinite());
  CHECK((unseen - said).norm() > 1e-6);
  // Where captures of the fit show none, views do not count.
  std::vector<Capture> captures = glides(0, 60);
  captures[7] = hidden;
  CHECK_THAT(trained_by_glides(captures).shares(0),
             Catch::EndsWith("; the autoregression does not look at views"));
}
