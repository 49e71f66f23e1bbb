/// Coefficients that change along a motion.
#include "samara/identification/series/coefficient_series.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "../error_text.h"
#include "plate_captures.h"
#include "samara/base/errors.h"
#include "samara/codebooks/query/query.h"
#include "samara/identification/series/series_codebook.h"
#include "samara/identification/series/series_config.h"
#include "samara/identification/series/series_knots.h"
#include "samara/identification/series/series_report.h"
#include "samara/identification/series/series_spans.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

using namespace samara::identification;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using samara::models::find_model;

namespace {

constexpr double kSeriesEnd = 8.0;
constexpr int kSeriesFrames = 121;
constexpr double kSeriesNoise = 0.01;  ///< of the unit of length, and rad

/// The rotational lift of a plate in a flow that changes.
class Swell final : public samara::models::ParameterCourse {
 public:
  explicit Swell(double height) : height_(height) {}
  static double at(double t, double height) { return 2.0 + height * std::sin(2.0 * M_PI * t / kSeriesEnd); }
  const std::vector<std::string>& followed() const override { return followed_; }
  void values(double t, std::span<const double>, std::span<double> followed) const override {
    followed[0] = at(t, height_);
  }

 private:
  double height_;
  std::vector<std::string> followed_ = {"C_R"};
};

const std::map<std::string, double>& plate_fixed() {
  static const std::map<std::string, double> fixed = {
      {"inertia_ratio", 1.1}, {"beta", 1.0 / 14.0}, {"C_T", 1.2}, {"A", 1.4}, {"B", 1.0}, {"mu1", 0.2}};
  return fixed;
}

/// A fluttering plate, by CVODES, in its first swings.
Capture fluttering(double height, std::uint64_t seed, double noise = kSeriesNoise) {
  std::map<std::string, double> values = plate_fixed();
  values["theta(0)"] = 0.6;
  values["vx(0)"] = 0.5;
  const auto model =
      samara::models::following(find_model("falling_plate_nd"), std::make_shared<Swell>(height));
  std::vector<double> times;
  for (int k = 0; k < kSeriesFrames; ++k) times.push_back(kSeriesEnd * k / (kSeriesFrames - 1));
  const auto trajectory =
      samara::models::integrate(samara::models::ParametricModel(model, values, {}), {}, times);
  return seen_plate(times, trajectory.states, noise, seed);
}

/// Every `step`th frame from one on.
Capture thinned(const Capture& capture, Eigen::Index first, Eigen::Index step = 1) {
  const Eigen::Index last = capture.times.size() - 1;
  const auto frames = Eigen::seq(first, last, step);
  Capture some = capture;
  some.times = Eigen::VectorXd(capture.times(frames));
  for (Channel& channel : some.channels) channel.values = Eigen::VectorXd(channel.values(frames));
  return some;
}

FitOptions series_options() {
  FitOptions options;
  options.unknowns.fixed = plate_fixed();
  options.unknowns.box = {{"C_R", {0.3, 6.0}},
                          {"vx(0)", {-8.0, 8.0}},
                          {"vy(0)", {-8.0, 8.0}},
                          {"w(0)", {-8.0, 8.0}},
                          {"theta(0)", {-60.0, 60.0}}};
  options.loss = {.kind = LossKind::none,
                  .scales = {{"x", kSeriesNoise}, {"y", kSeriesNoise}, {"theta", kSeriesNoise}}};
  options.solver.step = 0.034;  // two in a frame interval of 1/15
  options.starts.count = 1;
  return options;
}

CoefficientSeries series_of(const Capture& capture, const SeriesOptions& series) {
  return fit_series(find_model("falling_plate_nd"), std::vector{capture}, series_options(), series);
}

std::string series_error(const FitOptions& options, const SeriesOptions& series) {
  try {
    fit_series(find_model("falling_plate_nd"), std::vector{fluttering(0.0, 1)}, options, series);
  } catch (const samara::ArgumentError& error) {
    return error.what();
  }
  return {};
}

/// How many instants miss the truth by more than three standard errors.
int misses(const CoefficientSeries& series, double height) {
  int count = 0;
  const SeriesCoefficient& c = series.coefficients.at(0);
  for (Eigen::Index k = 0; k < c.values.size(); ++k) {
    INFO("t = " << series.instants[k] << ": " << c.values[k] << " +- " << c.standard_errors[k] << ", truth "
                << Swell::at(series.instants[k], height));
    CHECK(std::isfinite(c.standard_errors[k]));
    const double off = std::abs(c.values[k] - Swell::at(series.instants[k], height));
    CHECK(off < 4.5 * c.standard_errors[k]);
    count += off < 3.0 * c.standard_errors[k] ? 0 : 1;
  }
  return count;
}

double distance(const CoefficientSeries& series, const Capture& capture, bool constant) {
  std::map<std::string, double> values = series.replay;
  auto model = find_model("falling_plate_nd");
  const auto book = series_codebook(series);
  if (constant) {
    values["C_R"] = series.constant.coefficients.at(0).value;
    for (const Nuisance& n : series.constant.captures.at(0).nuisances) {
      if (n.name.ends_with("(0)")) values[n.name] = n.value;
      if (n.name == "offset of x") values["x(0)"] = n.value;
      if (n.name == "offset of y") values["y(0)"] = n.value;
    }
  } else {
    model = samara::models::following(model, codebook_course(book, model->info()));
  }
  const std::vector<double> times(capture.times.begin(), capture.times.end());
  const auto trajectory =
      samara::models::integrate(samara::models::ParametricModel(model, values, {}), {}, times);
  return std::sqrt((trajectory.states.col(4) - capture.channel("x").values).squaredNorm() / kSeriesFrames);
}

}  // namespace

TEST_CASE(
    "a coefficient that changes smoothly is recovered within its errors, and its replay is the capture") {
  const Capture capture = fluttering(0.6, 5);
  const CoefficientSeries series = series_of(capture, {.coefficients = {"C_R"}, .span = 0.8});
  INFO(series.message);
  REQUIRE(series.status == samara::Termination::converged);
  CHECK(series.joined);
  CHECK(series.spans == 10);
  REQUIRE(series.instants.size() == 12);
  CHECK(series.instants[1] == Approx(0.4));
  // A normal error beyond three standard errors is one in 370; errors of neighbours are correlated.
  CHECK(misses(series, 0.6) == 0);
  // A sine has some 4 to 8 free values in 12.
  CHECK(series.effective > 3.0);
  CHECK(series.effective < 12.0);
  // The spans are joined: a simulation from the first frame stays at the capture, to its noise and the
  // error of the steps; with the best constant coefficient it does not.
  CHECK(distance(series, capture, false) < 3.0 * kSeriesNoise);
  CHECK(distance(series, capture, true) > 2.0 * distance(series, capture, false));

  {  // A codebook of one axis holds it, with its errors as certificate.
    const auto book = series_codebook(series);
    CHECK(book.coordinate_count() == 1);
    CHECK(book.coordinates()[0].name == "t");
    CHECK(book.coordinates()[0].upper == Approx(kSeriesEnd));
    CHECK(book.outputs()[0].name == "C_R");
    samara::codebooks::Query query(book);
    Eigen::VectorXd value(1);
    const SeriesCoefficient& c = series.coefficients[0];
    for (Eigen::Index k = 0; k + 1 < series.instants.size(); ++k) {
      const double middle = 0.5 * (series.instants[k] + series.instants[k + 1]);
      query.values({&middle, 1}, value);
      CHECK_THAT(value[0], WithinAbs(0.5 * (c.values[k] + c.values[k + 1]), 1e-12));
    }
    REQUIRE(book.certificate());
    CHECK(book.certificate()->met);
    CHECK(book.certificate()->outputs[0].max_si == Approx(c.standard_errors.maxCoeff()));
    CHECK_THAT(book.certificate()->integrator, Contains("standard errors"));
  }
  {  // The series of one model does not steer another.
    const auto book = series_codebook(series);
    CHECK_THROWS_WITH(codebook_course(book, find_model("falling_plate")->info()),
                      Contains("coefficients of falling_plate_nd"));
  }
}

TEST_CASE("a coefficient that does not change is a straight line within its errors, and the series says so") {
  const CoefficientSeries series = series_of(fluttering(0.0, 6), {.coefficients = {"C_R"}, .span = 0.8});
  REQUIRE(series.status == samara::Termination::converged);
  CHECK(misses(series, 0.0) == 0);
  // A straight line has two free values; the smoothest factors bring little more.
  CHECK(series.effective < 4.0);
  // Only the ends of a line have no neighbours on both sides.
  CHECK(std::ranges::count(series.coefficients[0].basis, InstantBasis::neighbours) >= 10);
}

TEST_CASE(
    "how far a box goes beyond all values does not decide the smoothness, though some lie at its other end") {
  const Capture capture = fluttering(0.0, 6);
  const auto trials_up_to = [&](double upper) {
    FitOptions options = series_options();
    options.unknowns.box["C_R"] = {2.0, upper};
    const CoefficientSeries series = fit_series(find_model("falling_plate_nd"), std::vector{capture}, options,
                                                {.coefficients = {"C_R"}, .span = 0.8});
    // The truth is where the box begins.
    CHECK(std::ranges::count(series.coefficients.at(0).basis, InstantBasis::bound) > 0);
    CHECK(series.coefficients.at(0).values.maxCoeff() < 3.9);
    return series.trials;
  };
  const auto near = trials_up_to(4.0), far = trials_up_to(16.0);
  const std::size_t common = std::min(near.size(), far.size());
  REQUIRE(common > 1);
  for (std::size_t k = 1; k < common; ++k) {
    REQUIRE(near[k].factor == far[k].factor);
    CHECK_THAT(near[k].criterion - near[0].criterion, WithinAbs(far[k].criterion - far[0].criterion, 0.1));
  }
}

TEST_CASE("a series whose mean is far from what was known of its coefficient is warned of") {
  const Capture capture = fluttering(0.0, 6);
  const auto clashes = [&](double deviation) {
    FitOptions options = series_options();
    options.priors.coordinates["C_R"] = {.mean = 3.0, .deviation = deviation};
    const CoefficientSeries series = fit_series(find_model("falling_plate_nd"), std::vector{capture}, options,
                                                {.coefficients = {"C_R"}, .span = 0.8});
    REQUIRE(series.status == samara::Termination::converged);
    const double mean = series.coefficients[0].values.mean();
    INFO("mean " << mean);
    const std::vector<std::string> sentences = series.warnings.sentences();
    return std::ranges::any_of(sentences, [&](const std::string& sentence) {
      return sentence.starts_with(fmt::format("the mean of C_R = {:.6g} lies {:.3g} deviations of its prior",
                                              mean, (3.0 - mean) / deviation));
    });
  };
  CHECK(clashes(0.1));
  CHECK_FALSE(clashes(1.0));
}

TEST_CASE("noise levels that are estimated choose the smoothness that known ones choose") {
  FitOptions known = series_options();
  known.solver.step = 0.067;  // a frame interval: many fits
  FitOptions estimated = known;
  estimated.loss.scales.clear();
  estimated.noise.estimated = true;
  const SeriesOptions spans = {.coefficients = {"C_R"}, .span = 0.8};
  const auto series_by = [&](const FitOptions& options, double height) {
    return fit_series(find_model("falling_plate_nd"), std::vector{fluttering(height, 5)}, options, spans);
  };
  const auto height = GENERATE(0.6, 0.0);
  const CoefficientSeries series = series_by(estimated, height);
  INFO(series.message);
  REQUIRE(series.status == samara::Termination::converged);
  CHECK(misses(series, height) == 0);
  REQUIRE(series.fit.noise.size() == 3);
  // Of 120 values a level is known to 1/sqrt(240).
  for (const NoiseLevel& level : series.fit.noise)
    CHECK_THAT(level.value, WithinAbs(kSeriesNoise, 0.26 * kSeriesNoise));
  if (height == 0.0) {
    CHECK(series.effective < 4.0);
  } else {
    const CoefficientSeries reference = series_by(known, height);
    CHECK(series.factor == reference.factor);
    CHECK_THAT(series.effective, WithinAbs(reference.effective, 0.5));
  }
}

TEST_CASE("spans that slide recover the coefficient too, with start states of their own") {
  const CoefficientSeries series =
      series_of(fluttering(0.6, 7), {.coefficients = {"C_R"}, .span = 1.6, .stride = 0.8});
  INFO(series.message);
  REQUIRE(series.status == samara::Termination::converged);
  CHECK_FALSE(series.joined);
  CHECK(series.spans == 9);
  CHECK(series.fit.captures.size() == 9);
  CHECK(misses(series, 0.6) <= 1);
}

TEST_CASE("spans that slide reach from the first frame to the last, a stride or less apart") {
  const auto spans = [](double stride) {
    return series_spans(std::vector{fluttering(0.0, 1)}, series_options(),
                        {.coefficients = {"C_R"}, .span = 1.6, .stride = stride});
  };
  const SeriesSpans uneven = spans(1.5);
  CHECK(uneven.count == 6);
  CHECK_THAT(uneven.spacing, WithinAbs(1.28, 1e-12));
  CHECK(uneven.captures.back().times.tail<1>()[0] == kSeriesEnd);
  CHECK_THAT(uneven.knots.instants[6], WithinAbs(kSeriesEnd - 0.8, 1e-12));
  const SeriesSpans even = spans(1.6);
  CHECK(even.count == 5);
  CHECK_THAT(even.spacing, WithinAbs(1.6, 1e-12));
}

TEST_CASE("a series says what its steps cost, and warns where they are too long") {
  FitOptions options = series_options();
  options.segments.length = 2.0;
  const SeriesOptions straight = {.coefficients = {"C_R"}, .span = 0.8, .scales = {{"C_R", 1e-4}}};
  const auto with = [&](const Capture& capture, double step) {
    options.solver.step = step;
    return fit_series(find_model("falling_plate_nd"), std::vector{capture}, options, straight);
  };
  const Capture capture = fluttering(0.0, 6, 1e-6);
  const CoefficientSeries fine = with(capture, 0.01);
  CHECK(fine.fit.integration_shift.value() < 0.1);
  CHECK_FALSE(fine.warnings.has(WarningKind::steps, "steps of the integration are too long"));
  // Steps of 0.4: one from frame to frame.
  const CoefficientSeries coarse = with(thinned(capture, 0, 6), 0.5);
  CHECK(coarse.fit.integration_shift.value() > 0.1);
  CHECK(coarse.warnings.has(WarningKind::steps, "steps of the integration are too long"));
  CHECK_THAT(series_text(coarse), Contains("steps of half the length would move no value by more than"));
}

TEST_CASE("the caller's smoothness is the one used, and a hard one gives a straight line") {
  const CoefficientSeries series =
      series_of(fluttering(0.6, 5), {.coefficients = {"C_R"}, .span = 0.8, .scales = {{"C_R", 1e-4}}});
  CHECK_FALSE(series.factor);
  CHECK(series.trials.empty());
  CHECK(series.coefficients[0].scale == 1e-4);
  CHECK_THAT(series.effective, WithinAbs(2.0, 0.1));
}

TEST_CASE("differences do not depend on how instants are spaced where the course is a parabola") {
  // Second differences of c = t^2 are 2 h^2 for a spacing h, weighed by the root of their share of the time.
  const Eigen::VectorXd even = Eigen::VectorXd::LinSpaced(5, 0.0, 2.0);
  const Eigen::VectorXd second = difference_rows(even, 2, 0.5) * even.cwiseAbs2();
  for (const double value : second) CHECK_THAT(value, WithinAbs(0.5, 1e-14));
  Eigen::VectorXd uneven(4);
  uneven << 0.0, 0.25, 0.75, 1.25;
  const Eigen::VectorXd rows = difference_rows(uneven, 2, 0.5) * uneven.cwiseAbs2();
  CHECK_THAT(rows[0], WithinAbs(0.5 * std::sqrt(0.375 / 0.5), 1e-14));
  CHECK_THAT(rows[1], WithinAbs(0.5, 1e-14));
  CHECK_THAT((difference_rows(uneven, 2, 0.5) * uneven).cwiseAbs().maxCoeff(), WithinAbs(0.0, 1e-14));
  CHECK_THAT((difference_rows(uneven, 1, 0.5) * Eigen::VectorXd::Ones(4)).cwiseAbs().maxCoeff(),
             WithinAbs(0.0, 1e-14));
}

TEST_CASE("a replay has what is known of the capture, and what is its own where frames are means too") {
  const SeriesOptions given = {.coefficients = {"C_R"}, .span = 0.8, .scales = {{"C_R", 0.1}}};
  FitOptions options = series_options();
  options.unknowns.fixed.erase("mu1");
  options.unknowns.box["mu1"] = {0.1, 0.4};
  Capture capture = fluttering(0.6, 5);
  {
    FitOptions known = options;
    known.unknowns.known = {{"mu1", "friction"}};
    capture.labels["friction"] = "0.2";
    const auto series = fit_series(find_model("falling_plate_nd"), std::vector{capture}, known, given);
    REQUIRE(series.status == samara::Termination::converged);
    REQUIRE(series.replay.contains("mu1"));
    CHECK(series.replay.at("mu1") == 0.2);
    CHECK(series.replay_units.at("mu1") == "1");
    CHECK(distance(series, capture, false) < 3.0 * kSeriesNoise);
  }
  options.unknowns.per_capture = {"mu1"};
  options.compared.averaged_frames = 3;
  const auto series = fit_series(find_model("falling_plate_nd"), std::vector{capture}, options, given);
  INFO(series.message);
  REQUIRE(series.status != samara::Termination::failed);
  CHECK(series.replay.contains("mu1"));
  // The state is half a mean before the first frame.
  CHECK_FALSE(series.replay.contains("theta(0)"));
  CHECK_FALSE(series.replay.contains("x(0)"));
}

TEST_CASE("a replay begins with the capture that begins first, or says that it has no initial values") {
  const SeriesOptions given = {.coefficients = {"C_R"}, .span = 0.8, .scales = {{"C_R", 0.1}}};
  const Capture whole = fluttering(0.6, 5);
  const auto of = [&](const std::vector<Capture>& captures) {
    return fit_series(find_model("falling_plate_nd"), captures, series_options(), given);
  };
  {
    Capture late = thinned(whole, 12);
    late.id = "late";
    const CoefficientSeries series = of({late, whole});
    INFO(series.message);
    REQUIRE(series.status == samara::Termination::converged);
    CHECK_THAT(series.replay.at("theta(0)"), WithinAbs(0.6, 3.0 * kSeriesNoise));
    CHECK(distance(series, whole, false) < 3.0 * kSeriesNoise);
    CHECK_FALSE(series.warnings.has(WarningKind::series, "no initial values"));
  }
  Capture blind = whole;
  for (Channel& channel : blind.channels) channel.values[0] = NAN;
  const CoefficientSeries series = of({blind});
  REQUIRE(series.status != samara::Termination::failed);
  CHECK(series.replay.contains("mu1"));
  CHECK_FALSE(series.replay.contains("theta(0)"));
  CHECK_FALSE(series.replay.contains("x(0)"));
  CHECK(series.warnings.has(WarningKind::series,
                            "nothing is compared before 0.0666667: it has no initial values"));
}

TEST_CASE("what is asked of constant coefficients or joined segments is refused where there is no answer") {
  const SeriesOptions joined = {.coefficients = {"C_R"}, .span = 0.8};
  SeriesOptions sliding = joined;
  sliding.stride = 0.4;
  const auto with = [&](const SeriesOptions& series, auto change) {
    FitOptions options = series_options();
    change(options);
    return series_error(options, series);
  };
  CHECK_THAT(with(joined, [](FitOptions& o) { o.uncertainty.profiles = true; }),
             Contains("profiles or a series"));
  CHECK_THAT(with(joined, [](FitOptions& o) { o.uncertainty.bootstrap.replicates = 20; }),
             Contains("20 replicates") && Contains("bootstrap or a series"));
  CHECK_THAT(with(joined,
                  [](FitOptions& o) {
                    o.measurement.delay = samara::models::Interval{0.0, 0.1};
                  }),
             Contains("\"delay\" is unknown, and a series takes clocks and sensors as they are"));
  CHECK_THAT(with(joined,
                  [](FitOptions& o) {
                    o.measurement.gains["x"] = {0.9, 1.1};
                  }),
             Contains("\"gain of x\" is unknown, and a series takes clocks and sensors as they are"));
  CHECK_THAT(with(sliding, [](FitOptions& o) { o.segments.length = 0.8; }),
             Contains("segments of 0.8 s and a series.stride"));
  CHECK_THAT(with(sliding, [](FitOptions& o) { o.noise.estimated = true; }),
             Contains("noise is not estimated where spans slide"));
}

TEST_CASE("what belongs to the start of a capture is not applied to each span that slides") {
  const SeriesOptions sliding = {.coefficients = {"C_R"}, .span = 0.8, .stride = 0.4};
  const auto with = [&](auto change) {
    FitOptions options = series_options();
    change(options);
    return series_error(options, sliding);
  };
  const auto not_free = Contains("\"theta(0)\" is not free in each");
  CHECK_THAT(with([](FitOptions& o) {
               o.unknowns.box.erase("theta(0)");
               o.unknowns.fixed["theta(0)"] = 0.6;
             }),
             not_free);
  CHECK_THAT(with([](FitOptions& o) { o.unknowns.shared = {"theta(0)"}; }), not_free);
  CHECK_THAT(with([](FitOptions& o) { o.unknowns.box.erase("theta(0)"); }), not_free);
  CHECK_THAT(with([](FitOptions& o) { o.unknowns.offsets = {{"x"}}; }),
             Contains("\"y(0)\" is not free in each") && Contains("\"y\" among the offsets"));
  CHECK_THAT(with([](FitOptions& o) {
               o.priors.coordinates["w(0)"] = {0.0, 0.1};
             }),
             Contains("the prior of \"w(0)\""));
  CHECK_THAT(with([](FitOptions& o) {
               o.unknowns.fixed.erase("mu1");
               o.unknowns.box["mu1"] = {0.1, 0.4};
               o.unknowns.per_capture = {"mu1"};
             }),
             Contains("\"mu1\" of each capture"));
  CHECK_THAT(with([](FitOptions& o) { o.camera.scale = 0.02; }), Contains("camera"));
}

TEST_CASE("what a series cannot be is one sentence") {
  const SeriesOptions good = {.coefficients = {"C_R"}, .span = 0.8};
  const auto with = [&](auto change) {
    SeriesOptions series = good;
    change(series);
    return series_error(series_options(), series);
  };
  CHECK_THAT(with([](SeriesOptions& s) { s.span = 9.0; }),
             Contains("series.span is 9 s, but capture \"plate\" lasts 8 s"));
  CHECK_THAT(with([](SeriesOptions& s) { s.coefficients.clear(); }),
             Contains("series.coefficients is empty"));
  CHECK_THAT(with([](SeriesOptions& s) { s.coefficients = {"C_R", "C_R"}; }), Contains("\"C_R\" twice"));
  CHECK_THAT(with([](SeriesOptions& s) { s.coefficients = {"C_r"}; }),
             Contains("no parameter \"C_r\"") && Contains("did you mean"));
  CHECK_THAT(with([](SeriesOptions& s) { s.coefficients = {"A"}; }), Contains("\"A\" is fixed"));
  CHECK_THAT(with([](SeriesOptions& s) { s.coefficients = {"mu2"}; }), Contains("no interval in the box"));
  CHECK_THAT(with([](SeriesOptions& s) { s.span = NAN; }), Contains("series.span is nan"));
  CHECK_THAT(with([](SeriesOptions& s) { s.stride = 1.0; }), Contains("series.stride is 1"));
  CHECK_THAT(with([](SeriesOptions& s) { s.order = 3; }), Contains("series.order is 3"));
  CHECK_THAT(with([](SeriesOptions& s) { s.scales = {{"A", 1.0}}; }), Contains("none of its coefficients"));
  CHECK_THAT(with([](SeriesOptions& s) { s.span = 1e-3; }), Contains("8000 values"));
}

TEST_CASE(
    "a config gives the smoothness of a temperature as a difference, which no scale with an offset is") {
  ConfigNames names;
  names.coordinates = {{"ambient", "K"}};
  const auto series = [&](const std::string& smoothness) {
    return parse_series_config(
        "[series]\ncoefficients = [\"ambient\"]\nspan = \"1 s\"\nsmoothness = { ambient = " + smoothness +
            " }\n",
        "fit.toml", names);
  };
  CHECK(series("\"2 K\"")->scales.at("ambient") == 2.0);
  const auto error = [&](const std::string& smoothness) {
    return error_text<samara::InputError>([&] { series(smoothness); });
  };
  CHECK_THAT(error("\"2 degC\""), Contains("fit.toml:4: [series.smoothness] ambient: ") &&
                                      Contains("a difference of temperatures is given in K"));
  CHECK_THAT(error("0"), Contains("is 0 K; more than 0 was expected"));
}

TEST_CASE("values of a series have names of their own, however long a recording has run") {
  const SeriesKnots knots{.instants = Eigen::Vector2d(1000.25, 1000.5), .coefficients = {"C_R"}};
  CHECK(knots.name(0, 0) == "C_R@1000.25");
  CHECK(knots.name(0, 1) == "C_R@1000.5");
}

TEST_CASE("an order of differences that no number of the program holds is refused by its value") {
  ConfigNames names;
  names.coordinates = {{"C_R", "1"}};
  CHECK_THAT(error_text<samara::InputError>([&] {
               parse_series_config("[series]\ncoefficients = [\"C_R\"]\nspan = \"1 s\"\norder = 4294967298\n",
                                   "fit.toml", names);
             }),
             Contains("fit.toml:4") && Contains("order") && Contains("is 4294967298; 1 or 2 was expected"));
}
