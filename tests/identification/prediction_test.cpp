#include "samara/identification/fit/prediction.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "closed_form_family.h"
#include "files.h"
#include "predicted_motions.h"
#include "samara/base/errors.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/prediction_scores.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "synthetic.h"

using namespace samara::identification;
using namespace predicted_motions;
using Catch::Matchers::Contains;

namespace {

/// theta = theta(0) + rate t.
class TurningFamily final : public ClosedFormFamily {
 public:
  TurningFamily()
      : ClosedFormFamily(
            {.model = "turning",
             .coordinates = {{"rate", "rad/s", false, 1.0, 9.0}, {"theta(0)", "rad", true, -9.0, 9.0}},
             .outputs = {{"theta", "rad"}}},
            [](std::span<const double> q, double t, auto& values, auto* derivatives) {
              values << q[1] + q[0] * t;
              if (derivatives) *derivatives << t, 1.0;
            }) {}
};

constexpr double kFrameInterval = 0.01;

/// Depths of a braked motion from t = -20 ms on, each the mean of five frames.
Capture braked_means(const std::string& id, double v0, int frames) {
  std::vector<double> times;
  Eigen::VectorXd means = Eigen::VectorXd::Zero(frames);
  for (int k = 0; k < frames; ++k) {
    times.push_back(kFrameInterval * k);
    for (int j = 0; j <= 4; ++j)
      means[k] += BrakedFamily::depth(1.4, v0, times.back() + j * kFrameInterval) / 5.0;
  }
  return make_capture(id, times, means);
}

Capture without_frames(const Capture& capture, const std::vector<Eigen::Index>& kept) {
  Capture result = capture;
  result.times = capture.times(kept).eval();
  for (std::size_t c = 0; c < capture.channels.size(); ++c) {
    result.channels[c].values = capture.channels[c].values(kept).eval();
  }
  return result;
}

/// A plate that begins to turn, seen with a noise of position only.
Capture turning_plate(const std::string& id, double rate, std::mt19937_64& random) {
  std::map<std::string, double> values = plate();
  values["C_D90"] = 1.2;
  values["uz(0)"] = -0.3;
  values["wx(0)"] = rate;
  const samara::models::ParametricModel model(samara::models::find_model("immersed_body"), values, {});
  const std::vector<double> times = even_times(31, 0.3);
  const auto trajectory = samara::models::integrate(model, {}, times);
  Capture capture = make_capture(id, times, trajectory.states.col(0));
  capture.channels.push_back({"y", "m", trajectory.states.col(1)});
  capture.channels.push_back({"z", "m", trajectory.states.col(2)});
  add_noise(capture, 1e-3, random);
  const std::vector<std::string> parts = {"qw", "qx", "qy", "qz"};
  for (std::size_t k = 0; k < parts.size(); ++k) {
    capture.channels.push_back({parts[k], "1", trajectory.states.col(static_cast<int>(k) + 3)});
  }
  return capture;
}

}  // namespace

TEST_CASE("the true model predicts captures left out to the last digits, and baselines do not") {
  const BrakedFamily family;
  const FitResult fitted = fit(family, braked(0, 4, 0.0), plain());
  const std::vector<Capture> left_out = braked(4, 3, 0.0);
  const auto scores = predict_left_out(family, fitted, left_out, plain(), {.span = 0.6, .ahead = 0.5});
  // Six predictors, at the end and on the way.
  REQUIRE(scores.size() == 12);
  const PredictionScore& model = of(scores, "model", "position, 0.5 s ahead");
  CHECK(model.captures == 3);
  CHECK(model.count == 3);
  CHECK(model.unit == "m");
  CHECK(model.largest < 1e-6);
  // v = exp(-1.4 t): the straight line runs on at the mean speed of the span.
  CHECK(of(scores, "straight line", "position, 0.5 s ahead").median > 0.05);
  CHECK(of(scores, "cubic", "position, 0.5 s ahead").median <
        of(scores, "quadratic", "position, 0.5 s ahead").median);
  // Ten frames of 50 ms each.
  CHECK(of(scores, "model", "position, up to 0.5 s ahead").count == 30);
}

TEST_CASE("with noise the model is better than every baseline") {
  const BrakedFamily family;
  const FitResult fitted = fit(family, braked(0, 6, 2e-3), plain());
  const auto scores =
      predict_left_out(family, fitted, braked(6, 20, 2e-3), plain(), {.span = 0.6, .ahead = 0.5});
  const double model = of(scores, "model", "position, 0.5 s ahead").median;
  CHECK(model < 0.01);
  for (const Baseline baseline : all_baselines()) {
    if (baseline == Baseline::measured_velocity) continue;  // nobody measures it
    if (baseline == Baseline::point_with_drag) continue;    // nothing is up
    CHECK(of(scores, to_string(baseline), "position, 0.5 s ahead").median > 2.0 * model);
  }
  for (const PredictionScore& score : scores) CHECK(score.best == (score.predictor == "model"));
}

TEST_CASE("captures without a span, or with nothing beyond it, are left out of all scores") {
  const BrakedFamily family;
  const FitResult fitted = fit(family, braked(0, 4, 0.0), plain());
  std::vector<Capture> left_out = braked(4, 3, 0.0);
  left_out[0] = first(left_out[0], 0.6);
  left_out[1].channels[0].values.head(11).setConstant(std::nan(""));
  const auto scores = predict_left_out(family, fitted, left_out, plain(), {.span = 0.6, .ahead = 0.5});
  for (const PredictionScore& score : scores) CHECK(score.captures == 1);
}

TEST_CASE("coordinates that the family holds from its box, and shared ones, are taken over") {
  const BrakedFamily family;
  FitOptions options = plain();
  options.unknowns.shared = {"v(0)"};
  options.unknowns.box = {{"k", {0.5, 3.0}}};
  std::vector<Capture> same = braked(0, 1, 0.0);
  const FitResult fitted = fit(family, same, options);
  same[0].id = "again";
  const auto scores = predict_left_out(family, fitted, same, options, {.span = 0.6, .ahead = 0.5});
  CHECK(of(scores, "model", "position, 0.5 s ahead").largest < 1e-6);
  // Nothing at all is the capture's own.
  options.unknowns.offsets = std::vector<std::string>{};
  const FitResult without = fit(family, same, options);
  CHECK(predict_left_out(family, without, same, options, {.span = 0.6, .ahead = 0.5})[0].largest < 1e-6);
}

TEST_CASE("spans may be fitted by multiple shooting, and captures may begin late") {
  const auto family = coin_family();
  FitOptions options;
  options.starts.count = 1;
  std::vector<Capture> captures;
  for (int c = 0; c < 3; ++c) captures.push_back(coin_capture(fmt::format("{}", c), 1.2, 0.1 * c, 0.05));
  const FitResult fitted = fit(*family, captures, options);
  for (Capture& capture : captures) capture.channels[0].values.head(2).setConstant(std::nan(""));
  options.segments.length = 0.1;
  const auto scores = predict_left_out(*family, fitted, captures, options, {.span = 0.25, .ahead = 0.1});
  // Segments join to a part of their own uncertainty, which without noise is that of the integrator.
  CHECK(scores[0].captures == 3);
  CHECK(of(scores, "model", "position, 0.1 s ahead").largest < 1e-5);
}

TEST_CASE("predictions see the attitudes of the span, which count as values") {
  std::mt19937_64 random(8);
  const auto family = plate_family();
  FitOptions options = plain();
  options.loss.length_scale = 1e-3;
  options.loss.attitude_scale = 1e-3;
  const FitResult fitted =
      fit(*family, std::vector{turning_plate("a", 2.0, random), turning_plate("b", 3.0, random)}, options);
  std::vector left_out = {turning_plate("c", 2.5, random)};
  const std::string ahead = "position, 0.1 s ahead";
  const double seen =
      of(predict_left_out(*family, fitted, left_out, options, {.span = 0.15, .ahead = 0.1}), "model", ahead)
          .largest;
  // Noise of 1 mm: speeds from 16 frames over 0.15 s err by 6 mm/s in each axis, carried 0.175 s from the
  // middle; with the noise of the frame ahead, 2.5 mm in space. Twice that.
  CHECK(seen < 5e-3);
  // Four frames hold 12 positions and 12 parts of turns, for 13 unknowns.
  CHECK(of(predict_left_out(*family, fitted, left_out, options, {.span = 0.03, .ahead = 0.1}), "model", ahead)
            .captures == 1);
  for (std::size_t k = 3; k < 7; ++k) left_out[0].channels[k].values.setConstant(0.5);
  CHECK(of(predict_left_out(*family, fitted, left_out, options, {.span = 0.15, .ahead = 0.1}), "model", ahead)
            .largest > 2.0 * seen);
  left_out[0].channels.resize(3);
  CHECK_THROWS_WITH(predict_left_out(*family, fitted, left_out, options, {.span = 0.15, .ahead = 0.1}),
                    Catch::Contains("capture \"c\" does not measure \"qw\""));
}

TEST_CASE("means of frames are predicted over the interval of the fit, also where frames are missing") {
  const BrakedFamily family;
  FitOptions options = plain();
  options.compared.averaged_frames = 5;
  const std::vector captures = {braked_means("a", 0.8, 60), braked_means("b", 1.1, 60)};
  const FitResult fitted = fit(family, captures, options);
  CHECK(fitted.captures[0].interval == Approx(kFrameInterval));
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < 60; ++k) {
    if (k % 5 != 3) kept.push_back(k);
  }
  const std::vector left_out = {without_frames(braked_means("c", 0.9, 60), kept)};
  // Means over a quarter more would be off by k v/2 (1.25^2 - 1) 2 (10 ms)^2, some 5e-5 m.
  CHECK(of(predict_left_out(family, fitted, left_out, options, {.span = 0.3, .ahead = 0.2}), "model",
           "position, 0.2 s ahead")
            .largest < 1e-6);
  // Also of captures of which nothing is their own.
  options.unknowns.fixed = {{"v(0)", 0.9}};
  options.unknowns.offsets = std::vector<std::string>{};
  const std::vector one = {braked_means("a", 0.9, 60)};
  const FitResult shared = fit(family, one, options);
  CHECK(of(predict_left_out(family, shared, left_out, options, {.span = 0.3, .ahead = 0.2}), "model",
           "position, 0.2 s ahead")
            .largest < 1e-6);
}

TEST_CASE("predictions refuse times that are none, and say nothing of fits that failed") {
  const BrakedFamily family;
  CHECK_THROWS_AS(predict_left_out(family, {}, {}, plain(), {.span = 0.0, .ahead = 0.5}),
                  samara::ArgumentError);
  CHECK(predict_left_out(family, {}, {}, plain(), {.span = 0.5, .ahead = 0.5}).empty());
}

TEST_CASE("angles are predicted on their circle") {
  // An angle that goes on evenly, read from -pi to pi: it jumps within the span, and beyond it.
  TurningFamily family;
  const std::vector<double> times = even_times(41, 2.0);
  const auto turning = [&](const std::string& id, double start, bool wraps) {
    Eigen::VectorXd angles(41);
    for (Eigen::Index k = 0; k < 41; ++k) {
      const double angle = start + 6.0 * times[static_cast<std::size_t>(k)];
      angles[k] = wraps ? std::remainder(angle, 2.0 * std::numbers::pi) : angle;
    }
    Capture capture = make_capture(id, times, angles);
    capture.channels[0] = {"theta", "1", angles};
    return capture;
  };
  FitOptions options = plain();
  options.starts.initial = {{"rate", 5.8}};
  options.loss.scales = {{"theta", 0.01}};
  const std::vector<Capture> seen = {turning("seen", 0.3, true)};
  const FitResult fitted = fit(family, seen, options);
  const std::vector<Capture> wrapped = {turning("a", 1.0, true), turning("b", 2.0, true)};
  const auto scores = predict_left_out(family, fitted, wrapped, options, {.span = 1.0, .ahead = 0.9});
  for (const char* predictor : {"model", "straight line", "cubic"}) {
    CHECK(of(scores, predictor, "theta, up to 0.9 s ahead").captures == 2);
    CHECK(of(scores, predictor, "theta, up to 0.9 s ahead").largest < 1e-6);
  }
}

TEST_CASE("captures that cannot be predicted are named with the reason, and empty rows are left out") {
  const BrakedFamily family;
  FitResult fitted = fit(family, braked(0, 4, 0.0), plain());
  std::vector<Capture> left_out = braked(4, 3, 0.0);
  left_out[0] = first(left_out[0], 0.6);
  left_out[1].channels[0].values.head(11).setConstant(std::nan(""));
  fitted.warnings = {};
  // The frames end at 1.5 s: nothing is 5 s ahead.
  add_predictions(family, left_out, plain(), {.span = 0.6, .ahead = 5.0}, fitted);
  REQUIRE(fitted.warnings.size() == 3);
  CHECK_THAT(fitted.warnings[0].sentence,
             Contains("capture \"4\" was not predicted: it has no frame between 0.6 s"));
  CHECK_THAT(fitted.warnings[1].sentence,
             Contains("capture \"5\" was not predicted") && Contains("too little to fit"));
  CHECK_THAT(fitted.warnings[2].sentence, Contains("predictions go to 0.9 s ahead"));
  REQUIRE(fitted.predictions.size() == 6);
  for (const PredictionScore& score : fitted.predictions) {
    CHECK(score.quantity == "position, up to 0.9 s ahead");
    CHECK(score.captures == 1);
  }
  add_predictions(family, std::span(left_out).first(1), plain(), {.span = 0.6, .ahead = 0.5}, fitted);
  CHECK(fitted.predictions.empty());
  CHECK(fitted.warnings.sentences().back() == "none of the captures left out could be predicted");
}

TEST_CASE("a capture on which the model fails counts for the baselines, and the failure is said") {
  struct Fragile final : samara::models::TrajectoryFamily {
    BrakedFamily whole;
    bool fails = false;
    const samara::models::FamilyInfo& info() const override { return whole.info(); }
    std::unique_ptr<samara::models::TrajectorySource> at(
        const std::vector<double>& times, const std::vector<std::string>& outputs) const override {
      struct None final : samara::models::TrajectorySource {
        samara::models::TrajectoryOutcome evaluate(std::span<const double>, Eigen::MatrixXd&,
                                                   Eigen::MatrixXd*) override {
          return {samara::models::TrajectoryStatus::not_integrated, "none here"};
        }
      };
      if (fails) return std::make_unique<None>();
      return whole.at(times, outputs);
    }
  };
  Fragile family;
  FitResult fitted = fit(family, braked(0, 4, 0.0), plain());
  fitted.warnings = {};
  family.fails = true;
  add_predictions(family, braked(4, 2, 0.0), plain(), {.span = 0.6, .ahead = 0.5}, fitted);
  CHECK(of(fitted.predictions, "model", "position, 0.5 s ahead").captures == 0);
  CHECK(of(fitted.predictions, "cubic", "position, 0.5 s ahead").captures == 2);
  REQUIRE(fitted.warnings.size() == 3);
  CHECK_THAT(fitted.warnings[0].sentence, Contains("capture \"4\" counts for the baselines only"));
  CHECK(fitted.warnings[2].sentence == "the model failed on 2 of 2 captures left out");
}

TEST_CASE("captures that were fitted are not predicted") {
  const BrakedFamily family;
  std::vector<Capture> captures = braked(0, 3, 0.0);
  for (Capture& capture : captures) capture.file = "drops.csv";
  const PredictionOptions prediction{.span = 0.6, .ahead = 0.5};
  const FitResult fitted = fit(family, captures, plain());
  const std::string refusal = "capture \"2\" is fitted as well as left out";
  const std::span<const Capture> left_out = std::span(captures).last(1);
  CHECK_THAT(
      error_of<samara::InputError>([&] { predict_left_out(family, fitted, left_out, plain(), prediction); }),
      Contains(refusal));
  CHECK_THAT(
      error_of<samara::InputError>([&] { check_left_out(family, captures, left_out, plain(), prediction); }),
      Contains(refusal));
}

TEST_CASE("pieces of a motion that was fitted are not predicted") {
  const BrakedFamily family;
  std::vector<Capture> captures = braked(0, 3, 0.0);
  for (Capture& capture : captures) capture.file = "drops.csv";
  // Named as the pieces between long gaps are.
  captures[2].motion = captures[2].id;
  captures[2].id += "#1";
  std::vector<Capture> left_out = {captures[2]};
  const PredictionOptions prediction{.span = 0.6, .ahead = 0.5};
  const FitResult fitted = fit(family, captures, plain());
  const std::string refusal = "capture \"2\" is fitted as well as left out";
  const auto predict = [&] { predict_left_out(family, fitted, left_out, plain(), prediction); };
  const auto check = [&] { check_left_out(family, captures, left_out, plain(), prediction); };
  for (const char* id : {"2#1", "2#2"}) {
    left_out[0].id = id;
    CHECK_THAT(error_of<samara::InputError>(predict), Contains(refusal));
    CHECK_THAT(error_of<samara::InputError>(check), Contains(refusal));
  }
}

TEST_CASE("the frame on the border of the span is seen, and not predicted") {
  const BrakedFamily family;
  const FitResult fitted = fit(family, braked(0, 3, 0.0), plain());
  std::vector<Capture> left_out = braked(3, 1, 0.0);
  // Rounding has put it a little after it, where first() still takes it for the span's.
  left_out[0].times[12] += 1e-6;
  CHECK(first(left_out[0], 0.6).frame_count() == 13);
  const auto scores = predict_left_out(family, fitted, left_out, plain(), {.span = 0.6, .ahead = 0.5});
  CHECK(of(scores, "model", "position, up to 0.5 s ahead").count == 10);
}

TEST_CASE("priors of combinations are of no concern once coefficients are held") {
  const BrakedFamily family;
  FitOptions options = plain();
  options.priors.combinations = {{.weights = {{"k", 2.0}}, .mean = 2.8, .deviation = 0.1}};
  const FitResult fitted = fit(family, braked(0, 3, 0.0), options);
  const auto scores =
      predict_left_out(family, fitted, braked(3, 1, 0.0), options, {.span = 0.6, .ahead = 0.5});
  CHECK(of(scores, "model", "position, 0.5 s ahead").largest < 1e-6);
}

TEST_CASE("with segments a codebook lasts from the first frame seen on, whatever its time") {
  BrakedFamily family;
  family.mutable_info().source = "codebook";
  family.mutable_info().end_time = 1.0;
  FitOptions options = plain();
  options.compared.span = 0.6;
  options.segments.length = 0.6;
  const PredictionOptions prediction{.span = 0.6, .ahead = 0.5};
  FitResult fitted = fit(family, braked(0, 3, 0.0), options);
  std::vector<Capture> left_out = braked(3, 2, 0.0);
  left_out[0].times.array() += 1.0;                                  // ends at 1.0 s after its first frame
  left_out[1].channels[0].values.head(2).setConstant(std::nan(""));  // at 1.1 s
  fitted.warnings = {};
  add_predictions(family, left_out, options, prediction, fitted);
  CHECK(fitted.warnings.empty());
  const PredictionScore& score = of(fitted.predictions, "model", "position, up to 0.5 s ahead");
  CHECK(score.count == 8 + 10);
  CHECK(score.largest < 1e-6);

  add_predictions(family, std::span(left_out).first(1), options, prediction, fitted);
  REQUIRE(fitted.warnings.size() == 1);
  CHECK(fitted.warnings[0].sentence ==
        "predictions go to 0.4 s ahead, not to 0.5 s: the codebook ends there");
  fitted.warnings = {};
  family.mutable_info().end_time = 0.6;
  add_predictions(family, std::span(left_out).first(1), options, prediction, fitted);
  REQUIRE(fitted.warnings.size() == 2);
  CHECK_THAT(fitted.warnings[0].sentence,
             Contains("the codebook ends at 1.6 s of its times and the span at 1.6 s"));
}

TEST_CASE("captures that lack what was fitted are refused before the fit") {
  const BrakedFamily family;
  std::vector<Capture> left_out = braked(4, 1, 0.0);
  left_out[0].channels[0].quantity = "z";
  CHECK_THROWS_AS(check_left_out(family, braked(0, 2, 0.0), left_out, plain(), {.span = 0.6, .ahead = 0.5}),
                  samara::ArgumentError);
}

TEST_CASE("the weight of a point is what buoyancy leaves of it, where both densities are held, else all") {
  const auto of_coin = [](const std::map<std::string, double>& fixed,
                          const std::map<std::string, samara::models::Interval>& box,
                          const std::map<std::string, double>& held = {}) {
    std::map<std::string, double> all = {{"area", 4.71435e-4}, {"thickness", 2.55e-3}};
    all.insert(fixed.begin(), fixed.end());
    FitOptions options;
    options.unknowns.fixed = held;
    return net_weight(
        *samara::models::reference_trajectories(samara::models::find_model("vertical_fall"), all, box),
        options);
  };
  const std::map<std::string, samara::models::Interval> drag = {{"C_D", {0.6, 2.0}}, {"v(0)", {-0.4, 0.8}}};
  std::map<std::string, samara::models::Interval> dense = drag;
  dense["density"] = {2000.0, 8000.0};
  const std::map<std::string, double> in_water = {
      {"density", 4000.0}, {"fluid_density", 1000.0}, {"g", 10.0}};
  CHECK(of_coin(in_water, drag) == Approx(7.5));
  CHECK(of_coin({{"fluid_density", 1000.0}, {"g", 10.0}}, dense) == 10.0);
  CHECK(of_coin({{"fluid_density", 1000.0}, {"g", 10.0}}, dense, {{"density", 2500.0}}) == Approx(6.0));

  // By masses, where a point mass beside counts, too.
  BrakedFamily blimp;
  blimp.mutable_info().fixed = {{"mass", 0.8}, {"displaced_mass", 0.9}};
  CHECK(net_weight(blimp, {}) == Approx(kStandardG * (1.0 - 0.9 / 0.8)));
  blimp.mutable_info().fixed["offset_mass"] = 0.2;
  CHECK(net_weight(blimp, {}) == Approx(0.1 * kStandardG));
  blimp.mutable_info().fixed.erase("displaced_mass");
  CHECK(net_weight(blimp, {}) == kStandardG);
}

TEST_CASE("a baseline that is silent where it is hard is not the best, and is compared where it speaks") {
  // x = t^3, of which four frames are seen: the cubic goes on to 64, the quadratic to 53.5, the straight line to 31.
  // Of the hard capture only three are, too few for the cubic.
  const auto capture = [](const std::string& motion, const Eigen::VectorXd& times, double end, double model) {
    CapturePrediction one{.motion = motion};
    one.seen.times = times;
    one.seen.positions = times.array().cube().matrix();
    if (motion == "hard") one.seen.positions.setZero();
    one.times = Eigen::VectorXd::Constant(1, 4.0);
    one.truth = Eigen::MatrixXd::Constant(1, 1, end);
    one.model = Eigen::MatrixXd::Constant(1, 1, model);
    return one;
  };
  const Eigen::VectorXd four = Eigen::VectorXd::LinSpaced(4, 0.0, 3.0);
  std::vector<CapturePrediction> predictions = {capture("a", four, 64.0, 65.0),
                                                capture("b", four, 64.0, 63.0),
                                                capture("hard", four.head(3), 100.0, 90.0)};
  for (std::size_t k = 0; k < predictions.size(); ++k) predictions[k].cluster = static_cast<int>(k);
  const std::vector<PredictionScore> scores =
      scores_of({{.name = "x", .unit = "m", .columns = {0}}}, predictions, {.span = 3.0, .ahead = 1.0}).all;
  const std::string ahead = "x, 1 s ahead";
  CHECK(of(scores, "cubic", ahead).count == 2);
  CHECK(of(scores, "model", ahead).behind_best == Approx(1.0 - 10.5));
  CHECK(of(scores, "cubic", ahead).behind_best == Approx(-10.5));
  CHECK(of(scores, "quadratic", ahead).behind_best == Approx(0.0).margin(1e-9));
}
