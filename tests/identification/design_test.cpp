#include "samara/identification/design/design.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "files.h"
#include "samara/identification/design/design_report.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/report/fit_report.h"
#include "samara/identification/report/read_fit.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// y = s A exp(-k t), where k is counted in `unit` and s is what a release sets.
class DecayFamily final : public samara::models::TrajectoryFamily {
 public:
  explicit DecayFamily(double unit = 1.0, bool ends_early = false) : unit_(unit), ends_early_(ends_early) {
    info_.model = "decay";
    info_.source = "closed form";
    info_.coordinates = {{"A", "1", false, 0.1, 10.0},
                         {"k", "s^-1", false, 0.01 / unit, 10.0 / unit},
                         {"s", "1", false, 0.5, 3.0}};
    info_.outputs = {{"y", "1"}};
  }
  const samara::models::FamilyInfo& info() const override { return info_; }
  std::unique_ptr<samara::models::TrajectorySource> at(const std::vector<double>& times,
                                                       const std::vector<std::string>&) const override {
    return std::make_unique<Source>(times, unit_, ends_early_);
  }

 private:
  struct Source final : samara::models::TrajectorySource {
    Source(std::vector<double> at_times, double of_unit, bool ends)
        : times(std::move(at_times)), unit(of_unit), ends_early(ends) {}
    samara::models::TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                               Eigen::MatrixXd* derivatives) override {
      for (std::size_t row = 0; row < times.size(); ++row) {
        const auto at = static_cast<Eigen::Index>(row);
        const double decayed = std::exp(-q[1] * unit * times[row]);
        values(at, 0) = q[2] * q[0] * decayed;
        if (!derivatives) continue;
        (*derivatives)(at, 0) = q[2] * decayed;
        (*derivatives)(at, 1) = -times[row] * unit * values(at, 0);
        (*derivatives)(at, 2) = q[0] * decayed;
      }
      if (ends_early) return {samara::models::TrajectoryStatus::not_integrated, "it ends early", 0.0};
      return {};
    }
    std::vector<double> times;
    double unit;
    bool ends_early;
  };

  double unit_;
  bool ends_early_;
  samara::models::FamilyInfo info_;
};

constexpr double kA = 2.0, kDecay = 0.8, kSigma = 0.01;

/// As if A and k, or k alone, had been fitted, with s known to be 1 in all captures.
FitResult decay_fit(const std::vector<double>& errors, double unit = 1.0) {
  FitResult fitted{.status = samara::Termination::converged, .message = "converged", .model = "decay"};
  const bool both = errors.size() == 2;
  if (both) fitted.coefficients.push_back({"A", "1", kA, 0.1, 10.0, {}, errors[0]});
  fitted.coefficients.push_back(
      {"k", "s^-1", kDecay / unit, 0.01 / unit, 10.0 / unit, {}, errors.back() / unit});
  if (!both) fitted.setup.unknowns.fixed["A"] = kA;
  fitted.setup.compared.outputs = {"y"};
  fitted.setup.unknowns.known.emplace("s", "s");
  fitted.clusters = 1;
  fitted.captures.push_back(
      {.id = "so far", .known = {{"s", 1.0}}, .times = Eigen::VectorXd::LinSpaced(101, 0.0, 5.0)});
  fitted.noise = {{.outputs = {"y"}, .unit = "1", .value = kSigma, .estimated = true}};
  return fitted;
}

/// Nothing but the answer of the fit, from a release as before.
DesignOptions at_the_answer() {
  return {.duration = 5.0, .frames = 201, .box = {{"s", {1.0, 1.0}}}, .draws = 1};
}

double expected(const Design& design, const std::string& name) {
  return std::ranges::find(design.coefficients, name, &ExpectedError::name)->expected;
}

}  // namespace

TEST_CASE("the best single time to see a decay is its time constant") {
  DesignOptions options = at_the_answer();
  options.times = 1;
  const Design design = design_experiment(DecayFamily(), decay_fit({0.1}), options);
  REQUIRE(design.times.size() == 1);
  CHECK_THAT(design.times[0], WithinAbs(1.0 / kDecay, 0.025));  // frames are that far apart
  // 1/error^2 = 1/0.1^2 + (t A exp(-1)/sigma)^2 at t = 1/k.
  const double there = design.times[0] * kA * std::exp(-kDecay * design.times[0]) / kSigma;
  CHECK_THAT(design.times_error, WithinRel(1.0 / std::sqrt(1.0 + 0.01 * there * there), 1e-9));
}

TEST_CASE("the best two times for amplitude and rate of a decay are its start and its time constant") {
  DesignOptions options = at_the_answer();
  options.times = 2;
  // Next to nothing is known so far: then det J = A t_2 exp(-k (t_1 + t_2)) is largest at t_1 = 0, t_2 = 1/k.
  const Design design = design_experiment(DecayFamily(), decay_fit({500.0, 500.0}), options);
  REQUIRE(design.times.size() == 2);
  CHECK(design.times[0] == 0.0);
  CHECK_THAT(design.times[1], WithinAbs(1.0 / kDecay, 0.025));
}

TEST_CASE("of a long film as many times are chosen as were asked for") {
  DesignOptions options = at_the_answer();  // of 201 frames, every second of which is enough for fewer times
  options.times = 120;
  const Design design = design_experiment(DecayFamily(), decay_fit({0.1}), options);
  REQUIRE(design.times.size() == 120);
  for (std::size_t k = 1; k < design.times.size(); ++k) CHECK(design.times[k] > design.times[k - 1]);
}

TEST_CASE("errors expected are those of the sum of what is known and what is seen") {
  const DesignOptions options = at_the_answer();
  const Design design = design_experiment(DecayFamily(), decay_fit({0.003}), options);
  double information = 1.0 / (0.003 * 0.003);
  for (int frame = 0; frame < 201; ++frame) {
    const double t = 5.0 * frame / 200;
    information += std::pow(t * kA * std::exp(-kDecay * t) / kSigma, 2);
  }
  CHECK_THAT(expected(design, "k"), WithinRel(1.0 / std::sqrt(information), 1e-9));
  CHECK_THAT(design.error, WithinRel(1.0 / std::sqrt(information) / 0.003, 1e-9));
  REQUIRE(design.lengths.size() == 101);  // every other of 201 frames
  CHECK(design.lengths.back().share == 1.0);
  CHECK(design.sufficient_duration < 5.0);
  for (std::size_t k = 1; k < design.lengths.size(); ++k)
    CHECK(design.lengths[k].error <= design.lengths[k - 1].error);
  CHECK(design.frame_counts.at(0).frames == 101);
  CHECK(design.frame_counts.at(0).error > design.error);
}

TEST_CASE("a release that makes everything larger goes to the end of its box") {
  DesignOptions options = at_the_answer();
  options.box.clear();
  options.draws = 8;
  for (const int captures : {1, 3}) {
    options.captures = captures;
    const Design design = design_experiment(DecayFamily(), decay_fit({0.1, 0.1}), options);
    REQUIRE(design.coordinates.size() == 1);
    REQUIRE(std::ssize(design.captures) == captures);
    for (const ProposedCapture& capture : design.captures)
      CHECK_THAT(capture.release[0], WithinRel(3.0, 5e-3));
    CHECK(design.error < design.random_error);
  }
}

TEST_CASE("more captures never leave larger errors") {
  DesignOptions options = at_the_answer();
  options.box.clear();
  options.draws = 8;
  for (const DesignCriterion criterion : {DesignCriterion::determinant, DesignCriterion::trace}) {
    options.criterion = criterion;
    double before = 1.0;
    for (const int captures : {1, 2, 4}) {
      options.captures = captures;
      const Design design = design_experiment(DecayFamily(), decay_fit({0.1, 0.1}), options);
      CHECK(design.error < before);
      before = design.error;
    }
  }
}

TEST_CASE("the D-optimal design does not depend on the units of coefficients") {
  DesignOptions options = at_the_answer();
  options.box.clear();
  options.draws = 8;
  options.times = 3;
  const Design seconds = design_experiment(DecayFamily(), decay_fit({0.1, 0.1}), options);
  const Design minutes =
      design_experiment(DecayFamily(1.0 / 60.0), decay_fit({0.1, 0.1}, 1.0 / 60.0), options);
  CHECK_THAT(minutes.captures[0].release[0], WithinRel(seconds.captures[0].release[0], 1e-6));
  CHECK(minutes.times == seconds.times);
  CHECK_THAT(expected(minutes, "k") / 60.0, WithinRel(expected(seconds, "k"), 1e-9));
  CHECK_THAT(minutes.error, WithinRel(seconds.error, 1e-9));
}

TEST_CASE("of one coefficient both criteria choose the same") {
  DesignOptions options = at_the_answer();
  options.coefficients = {"k"};
  options.times = 3;
  const Design d = design_experiment(DecayFamily(), decay_fit({0.1, 0.1}), options);
  options.criterion = DesignCriterion::trace;
  const Design a = design_experiment(DecayFamily(), decay_fit({0.1, 0.1}), options);
  CHECK(a.times == d.times);
  CHECK_THAT(a.times_error, WithinRel(d.times_error, 1e-9));
}

TEST_CASE("a fit of old and new captures has the errors that its design expected") {
  // Two routes: elimination of the own speed and offset from the derivatives of the design, and the fit
  // itself. Noise levels of 800 and 1200 frames are known to 2.5 and 2 %.
  const BrakedFamily family;
  const std::vector<double> times = even_times(400, 2.0);
  std::mt19937_64 random(5);
  std::vector<Capture> captures;
  for (const double v0 : {0.8, 0.9}) {
    captures.push_back(make_capture(fmt::format("{}", v0), times, BrakedFamily::depths(1.1, v0, times)));
    add_noise(captures.back(), 1e-3, random);
  }
  const FitOptions options{.loss = {.kind = LossKind::none, .length_scale = 1e-3}};
  const FitResult before = fit(family, captures, options);
  const std::vector<std::vector<double>> release = {{2.5}};
  const Design design = assess_releases(family, before, release);
  REQUIRE(design.coordinates.size() == 1);
  CHECK(design.coordinates[0].name == "v(0)");
  CHECK(design.frames == 400);
  captures.push_back(make_capture("new", times, BrakedFamily::depths(1.1, 2.5, times)));
  add_noise(captures.back(), 1e-3, random);
  const FitResult after = fit(family, captures, options);
  const double now = *before.coefficients[0].naive_standard_error,
               then = *after.coefficients[0].naive_standard_error;
  CHECK(then < 0.5 * now);
  CHECK_THAT(expected(design, "k"), WithinRel(then, 0.1));
  CHECK(std::isnan(design.random_error));

  SECTION("and where it is read from its file") {
    const TemporaryDirectory files;
    const FitResult read = read_fit(files.put("fit.json", fit_json(before)));
    CHECK(design_json(assess_releases(family, read, release)).substr(0, 600) ==
          design_json(design).substr(0, 600));
  }
  SECTION("and from a file without setup and naive covariance") {
    const TemporaryDirectory files;
    nlohmann::json older = nlohmann::json::parse(fit_json(before));
    older.erase("setup");
    older.erase("naive_covariance");
    const FitResult read = read_fit(files.put("fit.json", older.dump()));
    CHECK_THAT(expected(assess_releases(family, read, release), "k"), WithinRel(expected(design, "k"), 1e-9));
  }
}

TEST_CASE("errors from clusters raise the noise of new captures alike") {
  FitResult fitted = decay_fit({0.01});
  const Design naive = design_experiment(DecayFamily(), fitted, at_the_answer());
  fitted.clusters = 5;
  fitted.coefficients[0].standard_error = 0.03;
  fitted.whiteness = Whiteness{.tested = 5, .rejected = 5, .p_value = 1e-6};
  const Design clustered = design_experiment(DecayFamily(), fitted, at_the_answer());
  CHECK(clustered.errors_are_clustered);
  CHECK_THAT(clustered.inflation, WithinRel(9.0, 1e-9));
  CHECK_THAT(expected(clustered, "k"), WithinRel(3.0 * expected(naive, "k"), 1e-9));
  // White residuals, and no more scatter than chance gives between five: the naive errors are the better ones.
  fitted.whiteness->p_value = 0.4;
  fitted.coefficients[0].standard_error = 0.013;
  CHECK_FALSE(design_experiment(DecayFamily(), fitted, at_the_answer()).errors_are_clustered);
}

TEST_CASE("a coefficient that was not determined is known by its box") {
  FitResult fitted = decay_fit({0.1, 0.1});
  fitted.coefficients[0].determined = false;
  fitted.coefficients[0].naive_standard_error.reset();
  fitted.naive_covariance = Eigen::MatrixXd::Constant(2, 2, std::nan(""));
  const Design design = design_experiment(DecayFamily(), fitted, at_the_answer());
  CHECK_FALSE(design.coefficients[0].was_determined);
  CHECK_THAT(design.coefficients[0].now, WithinRel(9.9 / std::sqrt(12.0), 1e-12));
  CHECK(design.coefficients[0].expected < 0.05);
}

TEST_CASE("where no release has a trajectory there is no design") {
  const DecayFamily family(1.0, true);
  const FitResult fitted = decay_fit({0.1});
  CHECK_THAT(error_of<samara::NoResultError>([&] { design_experiment(family, fitted, at_the_answer()); }),
             Contains("none of the releases"));
  CHECK_THAT(error_of<samara::NoResultError>([&] { design_experiment(family, fitted); }),
             Contains("none of 128 releases"));
}

TEST_CASE("designs that cannot be made are refused in one sentence") {
  const DecayFamily family;
  const auto refused = [&](const FitResult& fitted, const DesignOptions& options) {
    return error_of<samara::ArgumentError>([&] { design_experiment(family, fitted, options); });
  };
  const FitResult good = decay_fit({0.1, 0.1});
  SECTION("by the fit") {
    FitResult fitted = good;
    fitted.model = "growth";
    CHECK_THAT(refused(fitted, {}),
               Contains("of the model \"growth\"") && Contains("\"decay\" was expected"));
    fitted = good;
    fitted.coefficients[0].name = "B";
    CHECK_THAT(refused(fitted, {}), Contains("\"B\"") && Contains("no such coordinate"));
    for (const double noise : {-1.0, 0.0, std::nan("")}) {
      fitted = good;
      fitted.noise[0].value = noise;
      CHECK_THAT(refused(fitted, {}), Contains("the noise of y in the fit is") && Contains("positive"));
    }
    fitted = good;
    fitted.coefficients[1].naive_standard_error = std::nan("");
    CHECK_THAT(refused(fitted, {}), Contains("standard error of \"k\""));
    fitted = good;
    fitted.coefficients.clear();
    CHECK_THAT(refused(fitted, {}), Contains("no coefficients"));
    fitted = good;
    fitted.setup.unknowns.known.clear();
    CHECK_THAT(refused(fitted, {}), Contains("\"s\" is free"));
    fitted = good;
    fitted.setup.compared.outputs = {"z"};
    CHECK_THAT(refused(fitted, {}), Contains("\"z\" is no output"));
  }
  SECTION("by what is asked for") {
    CHECK_THAT(refused(good, {.captures = 0}), Contains("captures is 0"));
    CHECK_THAT(refused(good, {.duration = -1.0}), Contains("duration"));
    CHECK_THAT(refused(good, {.frames = 1}), Contains("frames is 1"));
    CHECK_THAT(refused(good, {.captures = 100, .frames = 5000}), Contains("4e+06 frames; at most 500000"));
    CHECK_THAT(refused(good, {.frames = 100000}), Contains("100000 frames"));
    CHECK_THAT(refused(good, {.release = {"A"}}), Contains("\"A\" is not a coordinate that a capture has"));
    CHECK_THAT(refused(good, {.box = {{"s", {0.0, 2.0}}}}), Contains("0.5 to 3"));
    CHECK_THAT(refused(good, {.box = {{"s", {2.0, 1.0}}}}), Contains("\"s\""));
    CHECK_THAT(refused(good, {.outputs = {"x"}}), Contains("\"x\" is no output"));
    CHECK_THAT(refused(good, {.noise = {{"y", std::nan("")}}}), Contains("noise of \"y\""));
    CHECK_THAT(refused(good, {.noise = {{"z", 1.0}}}), Contains("\"z\" is not seen"));
    CHECK_THAT(refused(good, {.coefficients = {"C"}}), Contains("\"C\" is not a coefficient"));
    CHECK_THAT(refused(good, {.times = 102}), Contains("times is 102"));
    CHECK_THAT(refused(good, {.draws = 0}), Contains("draws is 0"));
    CHECK_THAT(error_of<samara::ArgumentError>([] { design_criterion_from_string("E"); }),
               Contains("D or A"));
  }
}
