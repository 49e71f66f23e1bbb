/// What predictions are made of, of what, and of which captures.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "closed_form_family.h"
#include "predicted_motions.h"
#include "samara/base/errors.h"
#include "samara/base/streams.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/forecast_comparison.h"
#include "samara/identification/report/fit_report.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

using namespace samara::identification;
using namespace predicted_motions;

TEST_CASE("attitudes and rates are predicted, too, and by the rates measured") {
  const auto family = plate_family();
  FitOptions options = plain();
  options.loss.length_scale = 1e-3;
  options.loss.attitude_scale = 1e-3;
  for (const char* name : {"ux", "uy", "uz", "wx", "wy", "wz"}) options.loss.scales[name] = 1e-2;
  const auto measured = [&](const std::string& id, double rate) {
    std::map<std::string, double> values = plate();
    values["C_D90"] = 1.2;
    values["uz(0)"] = -0.3;
    values["wx(0)"] = rate;
    const samara::models::ParametricModel model(samara::models::find_model("immersed_body"), values, {});
    const std::vector<double> times = even_times(31, 0.3);
    const auto trajectory = samara::models::integrate(model, {}, times);
    Capture capture = make_capture(id, times, trajectory.states.col(0));
    for (std::size_t k = 1; k < model.model().info().states.size(); ++k) {
      const auto& state = model.model().info().states[k];
      capture.channels.push_back(
          {state.name, state.unit, trajectory.states.col(static_cast<Eigen::Index>(k))});
    }
    return capture;
  };
  FitResult fitted = fit(*family, std::vector{measured("a", 2.0), measured("b", 3.0)}, options);
  REQUIRE(fitted.status == samara::Termination::converged);
  const std::vector left_out = {measured("c", 2.5), measured("d", 1.5)};
  add_predictions(*family, left_out, options, {.span = 0.15, .ahead = 0.1}, fitted);
  const auto& scores = fitted.predictions;
  for (const char* quantity : {"position", "velocity", "angular velocity", "attitude"}) {
    const std::string ahead = fmt::format("{}, 0.1 s ahead", quantity);
    CHECK(of(scores, "model", ahead).captures == 2);
    CHECK(of(scores, "model", ahead).best);
  }
  // Without noise, what the model lacks is that of its coefficients and starts.
  CHECK(of(scores, "model", "attitude, 0.1 s ahead").largest < 1e-3);
  CHECK(of(scores, "straight line", "attitude, 0.1 s ahead").median > 1e-2);
  CHECK(of(scores, "measured velocity", "attitude, 0.1 s ahead").unit == "rad");
  CHECK(of(scores, "measured velocity", "position, 0.1 s ahead").median <
        of(scores, "straight line", "position, 0.1 s ahead").median);
  // Each capture by itself: a distance at the end is its median.
  const auto own = std::ranges::find_if(fitted.capture_predictions, [](const PredictionScore& s) {
    return s.capture == "d" && s.predictor == "cubic" && s.quantity == "position, 0.1 s ahead";
  });
  REQUIRE(own != fitted.capture_predictions.end());
  CHECK(own->captures == 1);
  CHECK(own->count == 1);
}

TEST_CASE("known values that a capture left out lacks are unknowns of its own there") {
  const BrakedFamily family;
  FitOptions options = plain();
  options.unknowns.known = {{"v(0)", "speed"}};
  std::vector<Capture> captures = braked(0, 4, 0.0);
  for (int c = 0; c < 4; ++c)
    captures[static_cast<std::size_t>(c)].labels["speed"] = fmt::format("{}", 0.6 + 0.1 * c);
  const FitResult fitted = fit(family, captures, options);
  CHECK_THAT(fitted.coefficients[0].value, Catch::Matchers::WithinAbs(1.4, 1e-6));
  const PredictionOptions prediction{.span = 0.6, .ahead = 0.5};
  std::vector<Capture> left_out = braked(4, 2, 0.0);
  const std::string ahead = "position, 0.5 s ahead";
  CHECK(of(predict_left_out(family, fitted, left_out, options, prediction), "model", ahead).largest < 1e-6);
  // An empty cell says nothing; one that says something counts, also where it is wrong.
  left_out[0].labels["speed"] = "";
  left_out[1].labels["speed"] = "0.7";
  const auto scores = predict_left_out(family, fitted, left_out, options, prediction);
  CHECK(of(scores, "model", ahead).captures == 2);
  CHECK(of(scores, "model", ahead).largest > 0.05);
  // Also where nothing was unknown of the captures that were fitted, and segments find where others start.
  FitOptions no_own = options;
  no_own.unknowns.offsets = std::vector<std::string>{};
  no_own.segments.length = 10.0;
  for (Capture& capture : captures) capture.channels[0].values.array() -= capture.channels[0].values[0];
  const FitResult without = fit(family, captures, no_own);
  REQUIRE(without.captures[0].nuisances.empty());
  std::vector<Capture> late = braked(4, 1, 0.0);
  late[0].channels[0].values.array() -= late[0].channels[0].values[0];
  late[0].times.array() += 3.0;
  CHECK(of(predict_left_out(family, without, late, no_own, prediction), "model", ahead).largest < 1e-6);
  for (Capture& capture : captures) capture.channels[0].values.array() += 0.2 * std::stod(capture.id);
  // A prior is for them, not for the fit, where the value is known.
  options.priors.coordinates = {{"v(0)", {.mean = 1.0, .deviation = 1e-9}}};
  CHECK_THAT(fit(family, captures, options).coefficients[0].value, Catch::Matchers::WithinAbs(1.4, 1e-6));
  CHECK(of(predict_left_out(family, fitted, braked(4, 1, 0.0), options, prediction), "model", ahead).largest <
        1e-4);
  CHECK(of(predict_left_out(family, fitted, braked(5, 1, 0.0), options, prediction), "model", ahead).largest >
        1e-3);
}

TEST_CASE("spans along a capture are fitted with starts of their own, and predicted") {
  const BrakedFamily family;
  FitOptions options = plain();
  options.compared.span = 0.5;
  options.compared.stride = 0.25;
  FitResult fitted = fit(family, braked(5, 3, 1e-4), options);
  // From 0, 0.25, .., 1 s of 1.5.
  CHECK(fitted.captures.size() == 15);
  CHECK(fitted.clusters == 3);
  CHECK(fitted.captures[1].id == "5 from 0.25 s");
  CHECK(fitted.captures[1].whole == "5");
  CHECK_THAT(fitted.coefficients[0].value, Catch::Matchers::WithinAbs(1.4, 0.02));
  const std::vector left_out = braked(8, 2, 1e-4);
  add_predictions(family, left_out, options, {.span = 0.5, .ahead = 0.25, .stride = 0.25}, fitted);
  CHECK(of(fitted.predictions, "model", "position, 0.25 s ahead").captures == 8);
  CHECK(of(fitted.predictions, "model", "position, 0.25 s ahead").median < 2e-3);
  CHECK(of(fitted.predictions, "straight line", "position, 0.25 s ahead").median > 5e-3);
  // By capture, not by span.
  CHECK(std::ranges::count_if(fitted.capture_predictions, [](const PredictionScore& s) {
          return s.predictor == "model" && s.quantity == "position, 0.25 s ahead" && s.captures == 4;
        }) == 2);
  // Nor can spans of what was fitted be left out.
  std::vector<Capture> same = braked(5, 1, 0.0);
  same[0].file = "drops.csv";
  const FitResult of_file = fit(family, same, options);
  CHECK_THROWS_AS(
      predict_left_out(family, of_file, same, options, {.span = 0.5, .ahead = 0.25, .stride = 0.25}),
      samara::InputError);
}

TEST_CASE("spans of captures are not predicted by equations that depend on time, and whole captures are") {
  BrakedFamily family;
  family.mutable_info().autonomous = false;
  const std::vector captures = braked(0, 4, 0.0);
  const auto refusal = Catch::Matchers::Contains("stride: the equations of \"braked\" depend on time");
  PredictionOptions prediction{.span = 0.5, .ahead = 0.25, .stride = 0.25};
  CHECK_THROWS_WITH(check_folds(family, captures, plain(), prediction, {.count = 2}), refusal);
  CHECK_THROWS_WITH(
      check_left_out(family, std::span(captures).first(2), std::span(captures).last(2), plain(), prediction),
      refusal);
  prediction.stride.reset();
  check_folds(family, captures, plain(), prediction, {.count = 2});
  const FitResult fitted = fit(family, std::span(captures).first(2), plain());
  CHECK(of(predict_left_out(family, fitted, std::span(captures).last(2), plain(), prediction), "model",
           "position, 0.25 s ahead")
            .captures == 2);
}

TEST_CASE("each fold is predicted by a fit of the others") {
  const BrakedFamily family;
  const std::vector captures = braked(0, 6, 1e-4);
  FitResult fitted = fit(family, captures, plain());
  const PredictionOptions prediction{.span = 0.6, .ahead = 0.5};
  cross_validate(family, captures, plain(), prediction, {.count = 3}, fitted);
  CHECK(of(fitted.predictions, "model", "position, 0.5 s ahead").captures == 6);
  CHECK(fitted.capture_predictions.size() == 6 * fitted.predictions.size());
  // One capture, predicted by the others: with as many folds as captures, that is all there is to it.
  cross_validate(family, captures, plain(), prediction, {.count = 6}, fitted);
  const FitResult of_others = fit(family, std::span(captures).first(5), plain());
  const auto alone = predict_left_out(family, of_others, std::span(captures).last(1), plain(), prediction);
  const auto last = std::ranges::find_if(fitted.capture_predictions, [](const PredictionScore& s) {
    return s.capture == "5" && s.predictor == "model" && s.quantity == "position, 0.5 s ahead";
  });
  CHECK(last->median == Approx(of(alone, "model", "position, 0.5 s ahead").median));
  for (const int folds : {-1, 0, 1, 7}) {
    CHECK_THROWS_AS(cross_validate(family, captures, plain(), prediction, {.count = folds}, fitted),
                    samara::ArgumentError);
  }
  CHECK_THROWS_WITH(check_folds(family, std::span(captures).first(1), plain(), prediction, {.count = 2}),
                    Catch::Matchers::Contains("1 cluster"));
}

TEST_CASE("a model that fails on all captures that go far enough makes no forecast, and it is said why") {
  struct Fading final : samara::models::TrajectoryFamily {
    BrakedFamily whole;
    double end = 0.0;  // s
    const samara::models::FamilyInfo& info() const override { return whole.info(); }
    std::unique_ptr<samara::models::TrajectorySource> at(
        const std::vector<double>& times, const std::vector<std::string>& outputs) const override {
      struct None final : samara::models::TrajectorySource {
        samara::models::TrajectoryOutcome evaluate(std::span<const double>, Eigen::MatrixXd&,
                                                   Eigen::MatrixXd*) override {
          return {samara::models::TrajectoryStatus::not_integrated, "none here"};
        }
      };
      if (times.back() > end) return std::make_unique<None>();
      return whole.at(times, outputs);
    }
  };
  std::vector<Capture> captures = braked(0, 4, 1e-4);
  captures[3].times = captures[3].times.head(17).eval();  // to 0.8 s
  captures[3].channels[0].values = captures[3].channels[0].values.head(17).eval();
  FitOptions options = plain();
  options.compared.span = 0.6;
  const auto lack = [&](double end, double ahead) {
    Fading family;
    family.end = end;
    Warnings warnings;
    const ForecastErrors made = cross_validated_errors(family, captures, options,
                                                       {.span = 0.6, .ahead = ahead}, {.count = 2}, warnings);
    const bool is_any = std::ranges::any_of(made.errors, [](const ForecastError& e) {
      return e.predictor == "model" && std::isfinite(e.distance);
    });
    CHECK(is_any == made.lack.empty());
    return made.lack;
  };
  CHECK(lack(2.0, 0.5).empty());
  CHECK(lack(0.9, 0.15).empty());
  // The capture that ends at 0.8 s is predicted, but not so far.
  CHECK(lack(0.9, 0.5) ==
        "it failed on every capture that reaches 0.5 s ahead: there is no trajectory beyond the span");
  CHECK(
      lack(2.0, 5.0) ==
      "predictions go to 0.9 s ahead, not to 5 s: there is no frame to compare beyond; an `ahead` of at most "
      "0.9 s was expected");
  CHECK(lack(0.5, 0.5) == "its fits failed");
}

TEST_CASE("folds keep clusters together, and a seed draws them") {
  const BrakedFamily family;
  std::vector<Capture> captures = braked(0, 8, 1e-4);
  // Two captures of each drop; the drops' noise tells the fits apart.
  for (std::size_t k = 0; k < captures.size(); ++k) captures[k].labels["drop"] = fmt::format("{}", k / 2);
  FitOptions options = plain();
  options.uncertainty.cluster_by = {"drop"};
  const PredictionOptions prediction{.span = 0.6, .ahead = 0.5};
  const std::string ahead = "position, 0.5 s ahead";
  const auto error_of = [&](const std::vector<PredictionScore>& scores, const std::string& capture) {
    const auto found = std::ranges::find_if(scores, [&](const PredictionScore& s) {
      return s.capture == capture && s.predictor == "model" && s.quantity == ahead;
    });
    REQUIRE(found != scores.end());
    return found->median;
  };
  FitResult fitted = fit(family, captures, options);
  const auto validated = [&](const Folds& folds) {
    cross_validate(family, captures, options, prediction, folds, fitted);
    std::vector<double> errors;
    for (const Capture& capture : captures)
      errors.push_back(error_of(fitted.capture_predictions, capture.id));
    return errors;
  };
  // What cannot be predicted is said once, whichever folds it is in.
  FitResult short_sighted = fitted;
  cross_validate(family, captures, options, {.span = 0.6, .ahead = 1e-3}, {.count = 2}, short_sighted);
  CHECK(std::ranges::count_if(short_sighted.warnings, [](const Warning& warning) {
          return warning.sentence.find("was not predicted: it has no frame") != std::string::npos;
        }) == 1);
  // As many folds as drops: each drop by the three others.
  const FitResult of_others = fit(family, std::span(captures).first(6), options);
  const auto last = predict_left_out(family, of_others, std::span(captures).last(1), options, prediction);
  CHECK(validated({.count = 4})[7] == Approx(of(last, "model", ahead).median).epsilon(1e-6));
  CHECK_THROWS_AS(validated({.count = 5}), samara::ArgumentError);
  // What a seed deals is dealt again by it, and by others not.
  const auto in_order = validated({.count = 2});
  CHECK(validated({.count = 2, .seed = 1}) == validated({.count = 2, .seed = 1}));
  std::set<std::vector<double>> dealt = {in_order};
  for (std::uint64_t seed = 0; seed < 20; ++seed) dealt.insert(validated({.count = 2, .seed = seed}));
  // Four drops are two pairs in three ways.
  CHECK(dealt.size() == 3);
}

TEST_CASE("what is known of captures may be hidden where they are left out") {
  const BrakedFamily family;
  FitOptions options = plain();
  options.unknowns.known = {{"v(0)", "speed"}};
  options.priors.coordinates = {{"v(0)", {.mean = 0.8, .deviation = 1.0}}};
  std::vector<Capture> captures = braked(0, 6, 0.0);
  for (std::size_t k = 0; k < captures.size(); ++k)
    captures[k].labels["speed"] = fmt::format("{}", 0.6 + 0.1 * static_cast<double>(k));
  const FitResult fitted = fit(family, std::span(captures).first(5), options);
  PredictionOptions prediction{.span = 0.6, .ahead = 0.5};
  const std::string ahead = "position, 0.5 s ahead";
  captures[5].labels["speed"] = "0.7";
  const auto left_out = std::span(captures).last(1);
  CHECK(of(predict_left_out(family, fitted, left_out, options, prediction), "model", ahead).largest > 0.05);
  prediction.hidden = {"v(0)"};
  CHECK(of(predict_left_out(family, fitted, left_out, options, prediction), "model", ahead).largest < 1e-3);
  prediction.hidden = {"w(0)"};
  CHECK_THROWS_WITH(predict_left_out(family, fitted, left_out, options, prediction),
                    Catch::Matchers::Contains("w(0)"));
}

namespace {

/// What two models and a line are off in four forecasts of each of 40 captures, which share an effect of their own:
/// model two is a tenth of a unit worse.
std::vector<ForecastsOfModel> made_forecasts(std::uint64_t seed, ClusterOfCapture& clusters) {
  std::vector<ForecastsOfModel> models = {{.name = "one"}, {.name = "two"}};
  for (int capture = 0; capture < 40; ++capture) {
    samara::Stream stream(seed, static_cast<std::uint64_t>(capture));
    const std::string id = "drop " + std::to_string(capture);
    clusters[{"drops.csv", id}] = capture;
    const double shared = stream.normal();
    for (int part = 0; part < 4; ++part) {
      const auto add = [&](ForecastsOfModel& model, const std::string& predictor, double distance) {
        model.errors.push_back({.file = "drops.csv",
                                .motion = id,
                                .part = id + " from " + std::to_string(part),
                                .quantity = "position, 1 s ahead",
                                .unit = "m",
                                .predictor = predictor,
                                .distance = distance});
      };
      add(models[0], "model", 5.0 + 0.3 * shared + 0.1 * stream.normal());
      add(models[0], "straight line", 5.2 + 0.1 * stream.normal());
      add(models[1], "model", 5.1 - 0.2 * shared + 0.1 * stream.normal());
    }
  }
  return models;
}

}  // namespace

TEST_CASE("the errors of differences are the scatter that other captures would show") {
  constexpr int kSets = 150;
  double sum = 0.0, squares = 0.0, errors = 0.0;
  for (int set = 0; set < kSets; ++set) {
    ClusterOfCapture clusters;
    const auto models = made_forecasts(static_cast<std::uint64_t>(set), clusters);
    const auto compared = compare_forecasts(models, clusters, {.replicates = 100});
    REQUIRE(compared.size() == 1);
    CHECK(compared[0].forecasts == 160);
    CHECK(compared[0].clusters == 40);
    const ForecastDifference& difference = compared[0].predictors[1].rms.to_first;
    sum += difference.value;
    squares += difference.value * difference.value;
    errors += difference.error;
  }
  // About 0.5/sqrt(40) = 0.08: four times what 160 forecasts would give that are all independent. Its own error
  // from 150 sets is 6 %, and 40 clusters leave 1 % of bias.
  const double scatter = std::sqrt((squares - sum * sum / kSets) / (kSets - 1));
  CHECK(errors / kSets / scatter > 0.85);
  CHECK(errors / kSets / scatter < 1.15);
  CHECK(std::abs(sum / kSets - 0.1) < 0.02);
}

TEST_CASE("forecasts that one model does not make are left out for all, and counted") {
  ClusterOfCapture clusters;
  auto models = made_forecasts(1, clusters);
  std::erase_if(models[1].errors, [](const ForecastError& e) { return e.motion == "drop 7"; });
  for (ForecastError& e : models[0].errors) {
    if (e.motion == "drop 7") e.distance = 1e3;
  }
  const auto compared = compare_forecasts(models, clusters);
  REQUIRE(compared.size() == 1);
  CHECK(compared[0].forecasts == 156);
  const auto& predictors = compared[0].predictors;
  REQUIRE(predictors.size() == 3);
  CHECK(predictors[0].missed == 0);
  CHECK(predictors[1].missed == 4);
  CHECK(predictors[0].rms.value < 6.0);
  CHECK(std::isnan(predictors[0].rms.to_first.value));
  CHECK(compared[0].best_by_rms == "straight line");
  CHECK(predictors[0].rms.to_plain.value == predictors[0].rms.value - predictors[2].rms.value);
  CHECK(compare_forecasts(models, clusters)[0].predictors[1].median.to_first.error ==
        predictors[1].median.to_first.error);
}

TEST_CASE("a comparison of nothing, or of captures without a cluster, is refused") {
  ClusterOfCapture clusters;
  const auto models = made_forecasts(1, clusters);
  CHECK_THROWS_AS(compare_forecasts({}, clusters), samara::ArgumentError);
  CHECK_THROWS_AS(compare_forecasts(models, clusters, {.replicates = 1}), samara::ArgumentError);
  clusters.erase({"drops.csv", "drop 7"});
  CHECK_THROWS_WITH(compare_forecasts(models, clusters),
                    "the capture \"drop 7\" of a forecast is in no cluster");
}

TEST_CASE("fits of folds, and of captures left out, draw no posterior") {
  std::atomic<long> evaluations = 0;
  const BrakedFamily braking;
  const ClosedFormFamily family(
      braking.info(), [&](std::span<const double> q, double t, auto& values, auto* derivatives) {
        ++evaluations;
        values << BrakedFamily::depth(q[0], q[1], t);
        if (!derivatives) return;
        const double kt = q[0] * t;
        *derivatives << q[1] * (kt * std::exp(-kt) + std::expm1(-kt)) / (q[0] * q[0]),
            BrakedFamily::depth(q[0], 1.0, t);
      });
  const std::vector captures = braked(0, 4, 1e-3);
  const FitResult fitted = fit(family, captures, plain());
  const auto spent = [&](const FitOptions& options) {
    FitResult result = fitted;
    const long before = evaluations;
    cross_validate(family, captures, options, {.span = 0.6, .ahead = 0.5}, {.count = 2}, result);
    return evaluations - before;
  };
  FitOptions drawing = plain();
  drawing.uncertainty.posterior.samples = 40;
  CHECK(spent(drawing) == spent(plain()));
}

TEST_CASE("captures of one id in several files are scored each by itself") {
  const BrakedFamily family;
  FitResult fitted = fit(family, braked(0, 4, 0.0), plain());
  std::vector<Capture> left_out = braked(4, 2, 0.0);
  for (std::size_t k = 0; k < left_out.size(); ++k) {
    left_out[k].id = "drop";
    left_out[k].file = fmt::format("day {}.csv", k);
  }
  add_predictions(family, left_out, plain(), {.span = 0.6, .ahead = 0.5}, fitted);
  CHECK(fitted.capture_predictions.size() == 2 * fitted.predictions.size());
  for (const PredictionScore& score : fitted.capture_predictions) CHECK(score.captures == 1);
  // The report has both, and tells them apart.
  const std::string text = fit_text(fitted), json = fit_json(fitted);
  for (const char* file : {"day 0.csv", "day 1.csv"}) {
    CHECK(std::ranges::count(fitted.capture_predictions, file, &PredictionScore::file) ==
          std::ssize(fitted.predictions));
    CHECK_THAT(text, Catch::Contains(fmt::format("\ndrop ({})", file)));
    CHECK_THAT(json, Catch::Contains(fmt::format("\"file\": \"{}\"", file)));
  }
  CHECK(std::ranges::count(fitted.predictions, "", &PredictionScore::file) == std::ssize(fitted.predictions));
  // Ids that are there once stand alone.
  left_out[1].id = "other drop";
  add_predictions(family, left_out, plain(), {.span = 0.6, .ahead = 0.5}, fitted);
  CHECK_THAT(fit_text(fitted), Catch::Contains("\ndrop  ") && !Catch::Contains(".csv)"));
}
