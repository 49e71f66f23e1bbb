#include "samara/identification/fit/fit_warnings.h"

#include <algorithm>

#include <catch2/catch.hpp>

#include "closed_form_family.h"
#include "files.h"
#include "samara/base/errors.h"
#include "samara/identification/fit/fit.h"
#include "samara/models/laws/registry.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

std::vector<Capture> coins(double C_D) {
  std::vector<Capture> captures;
  std::mt19937_64 random(2);
  for (int c = 0; c < 4; ++c) {
    captures.push_back(coin_capture(fmt::format("coin {}", c), C_D, 0.05 * c, 0.1));
    add_noise(captures.back(), 2e-4, random);
  }
  return captures;
}

}  // namespace

TEST_CASE("a good fit warns of nothing") {
  const FitResult result = fit(*coin_family(), coins(1.15));
  CHECK(result.is_usable());
  CHECK(text_of(result.warnings).empty());
}

TEST_CASE("a fit that misses its captures by many loss scales says so") {
  std::vector<Capture> captures = coins(1.15);
  for (Capture& capture : captures) capture.channels[0].values *= 3.0;
  const FitResult result = fit(*coin_family(), captures);
  CHECK_THAT(text_of(result.warnings),
             Contains("the model misses x by") && Contains("times the loss scale of 0.002 m"));
}

TEST_CASE("an answer that priors all but rule out is warned of, and one that they allow is not") {
  // Frames are so exact that priors hardly move the answer, C_D = 1.15 and starting speeds of 0 to 0.15 m/s.
  const std::vector<Capture> captures = coins(1.15);
  FitOptions options;
  options.loss = {.kind = LossKind::none, .length_scale = 1e-4};
  const auto said = [&] {
    const FitResult result = fit(*coin_family(), captures, options);
    CHECK(result.warnings.has(WarningKind::model) == !result.warnings.empty());
    return text_of(result.warnings);
  };
  const std::string clash = "what was known of it beforehand and the captures contradict each other";
  SECTION("of a shared unknown, with a mean outside its box") {
    options.priors.coordinates["C_D"] = {.mean = -10.0, .deviation = 0.1};
    CHECK_THAT(said(), Contains("C_D = 1.1") && Contains("lies 11") &&
                           Contains(" deviations of its prior from the prior's mean: " + clash));
  }
  SECTION("of its logarithm: 1.15 is ln(1.15/0.7)/0.1 = 4.96 deviations from 0.7") {
    options.priors.coordinates["C_D"] = {.mean = 0.7, .deviation = 0.1, .logarithmic = true};
    CHECK_THAT(said(), Contains("C_D = 1.1") && Contains("lies 4.9") && Contains(clash));
    options.priors.coordinates["C_D"].mean = 0.9;
    CHECK(said().empty());
  }
  SECTION("of an unknown of each capture's own, with the captures in which it is so") {
    options.priors.coordinates["v(0)"] = {.mean = 0.0, .deviation = 0.02};
    CHECK_THAT(said(), Contains("v(0) lies up to 7.") &&
                           Contains("in 2 of 4 captures, \"coin 2\", \"coin 3\": " + clash));
    options.priors.coordinates["v(0)"].deviation = 0.1;
    CHECK(said().empty());
  }
}

TEST_CASE("where the equations depend on time a fit says that a table's first frame became time 0") {
  // x = amplitude sin(t) from 5 s on.
  const auto waves = [](bool autonomous) {
    return ClosedFormFamily({.model = "waves",
                             .coordinates = {{"amplitude", "m", false, 0.5, 2.0}},
                             .outputs = {{"x", "m"}},
                             .autonomous = autonomous},
                            [](std::span<const double> q, double t, auto& values, auto* derivatives) {
                              values << q[0] * std::sin(t);
                              if (derivatives) *derivatives << std::sin(t);
                            });
  };
  std::string table = "t[s],x[m]\n";
  for (int k = 0; k < 60; ++k) table += fmt::format("{0},{1}\n", 5.0 + 0.02 * k, std::sin(5.0 + 0.02 * k));
  const TemporaryDirectory files;
  const std::filesystem::path path = files.put("late.csv", table);
  const std::vector<Capture> moved = read_captures(path);
  CHECK(moved[0].start == 5.0);
  const std::string said = "capture \"late\": 5 s in its table is time 0 in the equations of \"waves\"";
  CHECK_THAT(text_of(fit(waves(false), moved).warnings), Contains(said));
  CHECK_THAT(text_of(fit(waves(true), moved).warnings), !Contains("in its table"));
  const std::vector<Capture> as_given =
      read_captures(files.put("late.toml", "file = \"late.csv\"\nstart = \"as given\"\n"));
  const FitResult result = fit(waves(false), as_given);
  CHECK_THAT(text_of(result.warnings), !Contains("in its table"));
  CHECK_THAT(result.coefficients.at(0).value, WithinRel(1.0, 1e-6));
  // Segments of a series know by their clock when they begin.
  samara::models::FamilyInfo clocked = waves(false).info();
  clocked.clock = "t_0";
  CHECK(moved_times(clocked, moved).empty());
  CHECK(moved_times(waves(false).info(), moved).size() == 1);
}

TEST_CASE("a state that is first measured long after the start is not held against the box of the start") {
  // x = x(0) + 2 t from 5 s on: none of the first frames is in the box of x(0).
  const ClosedFormFamily line({.model = "line",
                               .coordinates = {{"k", "m/s", false, 1.0, 3.0}, {"x(0)", "m", true, 0.0, 1.0}},
                               .outputs = {{"x", "m"}},
                               .autonomous = false},
                              [](std::span<const double> q, double t, auto& values, auto* derivatives) {
                                values << q[1] + q[0] * t;
                                if (derivatives) *derivatives << t, 1.0;
                              });
  std::vector<Capture> captures(1);
  Capture& capture = captures[0];
  capture.id = "late";
  capture.times = Eigen::VectorXd::LinSpaced(30, 5.0, 6.0);
  capture.channels = {{.quantity = "x", .unit = "m", .values = 0.5 + 2.0 * capture.times.array()}};
  const FitResult result = fit(line, captures);
  REQUIRE(result.is_usable());
  CHECK_THAT(result.coefficients.at(0).value, WithinRel(2.0, 1e-6));
  capture.times.array() -= 5.0;
  CHECK_THROWS_WITH(fit(line, captures), Contains("the box of \"x(0)\" goes from 0 to 1"));
}

TEST_CASE("scales that were stated count without a loss, too") {
  std::vector<Capture> captures = coins(1.15);
  for (Capture& capture : captures) capture.channels[0].values *= 3.0;
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.starts.count = 1;
  CHECK_THAT(text_of(fit(*coin_family(), captures, options).warnings), !Contains("the model misses"));
  options.loss.scales = {{"x", 1e-3}};
  CHECK_THAT(text_of(fit(*coin_family(), captures, options).warnings), Contains("the loss scale of 0.001 m"));
}

TEST_CASE("a fit that misses attitudes by many times their scale says so") {
  // Turns about z at up to 2 rad/s, seen at 4: 2 rad apart after 1 s.
  const ClosedFormFamily turns({.model = "turns",
                                .coordinates = {{"rate", "rad/s", false, 1.0, 2.0}},
                                .outputs = {{"qw", "1"}, {"qx", "1"}, {"qy", "1"}, {"qz", "1"}},
                                .attitude = {"qw", "qx", "qy", "qz"}},
                               [](std::span<const double> q, double t, auto& values, auto* derivatives) {
                                 const double half = 0.5 * q[0] * t;
                                 values << std::cos(half), 0.0, 0.0, std::sin(half);
                                 if (derivatives)
                                   *derivatives << -0.5 * t * std::sin(half), 0.0, 0.0,
                                       0.5 * t * std::cos(half);
                               });
  const Eigen::ArrayXd halves = Eigen::ArrayXd::LinSpaced(21, 0.0, 2.0);
  Capture capture = make_capture("fast", even_times(21, 1.0), halves.cos().matrix());
  capture.channels = {{"qw", "1", halves.cos().matrix()},
                      {"qx", "1", Eigen::VectorXd::Zero(21)},
                      {"qy", "1", Eigen::VectorXd::Zero(21)},
                      {"qz", "1", halves.sin().matrix()}};
  FitOptions options;
  options.loss.kind = LossKind::none;
  const auto said = [&] { return text_of(fit(turns, std::vector{capture}, options).warnings); };
  CHECK_THAT(said(), !Contains("the model misses"));
  options.loss.attitude_scale = 0.02;
  CHECK_THAT(said(),
             Contains("the model misses attitude by 1.") && Contains("times the loss scale of 0.02 rad"));
}

TEST_CASE("a channel that means nothing to the model is warned of, with what was perhaps meant") {
  std::vector<Capture> captures = coins(1.15);
  for (Capture& capture : captures) capture.channels.push_back({"xx", "m", capture.channels[0].values});
  FitOptions options;
  CHECK(text_of(fit(*coin_family(), captures, options).warnings) ==
        "capture \"coin 0\": \"xx\" is no output of \"vertical_fall\", and was not compared; did you mean "
        "\"x\"?");
  options.compared.outputs = {"x"};  // chosen by name
  CHECK(text_of(fit(*coin_family(), captures, options).warnings).empty());
}

TEST_CASE("a coefficient at a bound of its box is warned of, and has no error") {
  const auto family = coin_family();
  FitOptions options;
  options.unknowns.box = {{"C_D", {1.3, 2.0}}};
  const FitResult result = fit(*family, coins(1.0), options);
  const Coefficient& C_D = result.coefficients[0];
  CHECK(C_D.at_bound);
  CHECK(C_D.value == 1.3);
  CHECK_FALSE(C_D.standard_error);
  CHECK_FALSE(C_D.naive_standard_error);
  CHECK_THAT(text_of(result.warnings), Contains("C_D = 1.3 lies at a bound of its box, 1.3 to 2"));
}

TEST_CASE("an initial value at a bound is warned of with its captures") {
  const auto family = coin_family();
  FitOptions options;
  options.unknowns.box = {{"v(0)", {-0.1, 0.08}}};
  const FitResult result = fit(*family, coins(1.15), options);
  CHECK(result.captures[3].nuisances[0].at_bound);
  CHECK_FALSE(result.captures[3].nuisances[0].standard_error);
  CHECK_FALSE(result.captures[0].nuisances[0].at_bound);
  CHECK_THAT(text_of(result.warnings),
             Contains("v(0) lies at a bound of its box in 2 of 4 captures: \"coin 2\", \"coin 3\""));
}

TEST_CASE("coefficients that the captures cannot tell apart are named") {
  // Without added mass the area drops out of v' = (weight - drag)/mass.
  auto fixed = coin_fixed();
  fixed.erase("area");
  fixed["m_a"] = 0.0;
  fixed["g"] = 9.81;
  const auto family =
      reference_trajectories(samara::models::find_model("vertical_fall"), fixed,
                             {{"C_D", {0.6, 2.0}}, {"area", {3e-4, 6e-4}}, {"v(0)", {-0.4, 0.8}}});
  const FitResult result = fit(*family, coins(1.15));
  CHECK(result.status == samara::Termination::not_determined);
  CHECK_FALSE(result.is_usable());
  CHECK_THAT(result.message, Contains("do not determine all coefficients"));
  CHECK_THAT(text_of(result.warnings), Contains("the captures do not determine area: it can change"));
  CHECK(result.coefficients[0].determined);
  CHECK(result.coefficients[0].standard_error);
  CHECK_FALSE(result.coefficients[1].determined);
  CHECK_FALSE(result.coefficients[1].standard_error);

  SECTION("also where it takes several together") {
    // C_D and thickness count by their ratio only.
    fixed.erase("thickness");
    fixed["area"] = 4.71435e-4;
    const auto ratio =
        reference_trajectories(samara::models::find_model("vertical_fall"), fixed,
                               {{"C_D", {0.6, 2.0}}, {"thickness", {2e-3, 3e-3}}, {"v(0)", {-0.4, 0.8}}});
    const FitResult both = fit(*ratio, coins(1.15));
    CHECK(both.status == samara::Termination::not_determined);
    CHECK_THAT(text_of(both.warnings), Contains("do not determine C_D, thickness: they can change together"));
    CHECK_FALSE(both.coefficients[0].standard_error);
  }
}

TEST_CASE("an unknown of one capture that it cannot determine is named") {
  // A body that does not move says nothing about k; with all frames at one time, v(0) and offset are one.
  const BrakedFamily family;
  const std::vector<double> times = even_times(20, 1.5);
  std::vector<Capture> captures = {make_capture("moves", times, BrakedFamily::depths(1.4, 1.0, times)),
                                   make_capture("blinks", {1.0, 1.0, 1.0}, Eigen::Vector3d(0.5, 0.51, 0.49))};
  const FitResult result = fit(family, captures);
  CHECK_THAT(text_of(result.warnings), Contains("capture \"blinks\" does not determine its v(0)") &&
                                           Contains("capture \"blinks\" does not determine its offset of x"));
  CHECK_FALSE(result.captures[1].nuisances[0].standard_error);
  CHECK_THAT(result.coefficients[0].value, WithinRel(1.4, 1e-4));
}

TEST_CASE("a coefficient whose error fills its box is warned of") {
  // In 0.1 s, k bends the path by k v0 t^2/2, a few mm: lost in noise of 5 mm, which here alternates from
  // frame to frame so that it leaves the estimate where it is.
  const BrakedFamily family;
  const std::vector<double> times = even_times(6, 0.1);
  const Eigen::VectorXd noise =
      5e-3 * Eigen::VectorXd::Map(std::vector{1.0, -1.0, 1.0, -1.0, 1.0, -1.0}.data(), 6);
  std::vector<Capture> captures;
  for (const char* id : {"a", "b", "c"}) {
    captures.push_back(make_capture(id, times, BrakedFamily::depths(1.4, 1.0, times) + noise));
  }
  FitOptions options;
  options.loss.kind = LossKind::none;
  const FitResult result = fit(family, captures, options);
  CHECK_FALSE(result.coefficients[0].at_bound);
  CHECK_THAT(text_of(result.warnings), Contains("the captures say little about k"));
}

TEST_CASE("a single capture gives naive errors only, with a warning") {
  const FitResult result = fit(*coin_family(), std::vector{coins(1.15)[0]});
  CHECK(result.clusters == 1);
  CHECK_FALSE(result.coefficients[0].standard_error);
  CHECK(result.coefficients[0].naive_standard_error);
  CHECK_THAT(text_of(result.warnings), Contains("only one cluster"));
  CHECK(result.covariance(0, 0) == Approx(std::pow(*result.coefficients[0].naive_standard_error, 2)));
}

TEST_CASE("an iteration limit is a status, with the best point so far") {
  FitOptions options;
  options.solver.max_iterations = 1;
  const FitResult result = fit(*coin_family(), coins(1.15), options);
  CHECK(result.status == samara::Termination::max_iterations);
  CHECK_THAT(result.message, Contains("did not converge"));
  CHECK(result.coefficients.size() == 1);
}

namespace {

/// No trajectory anywhere, or an exception.
class BrokenFamily final : public samara::models::TrajectoryFamily {
 public:
  explicit BrokenFamily(bool throws) : throws_(throws) {}
  const samara::models::FamilyInfo& info() const override { return braked_.info(); }
  std::unique_ptr<samara::models::TrajectorySource> at(const std::vector<double>&,
                                                       const std::vector<std::string>&) const override {
    struct Source final : samara::models::TrajectorySource {
      explicit Source(bool does_throw) : throws(does_throw) {}
      samara::models::TrajectoryOutcome evaluate(std::span<const double>, Eigen::MatrixXd&,
                                                 Eigen::MatrixXd*) override {
        if (throws) throw samara::ArgumentError("no such luck");
        return {samara::models::TrajectoryStatus::not_integrated, "none here"};
      }
      bool throws;
    };
    return std::make_unique<Source>(throws_);
  }

 private:
  BrakedFamily braked_;
  bool throws_;
};

}  // namespace

TEST_CASE("a fit without any trajectory fails with a status") {
  const std::vector<double> times = even_times(5, 1.0);
  const std::vector captures = {make_capture("a", times, BrakedFamily::depths(1.0, 1.0, times))};
  const FitResult result = fit(BrokenFamily(false), captures);
  CHECK(result.status == samara::Termination::failed);
  CHECK_THAT(result.message, Contains("none of 3 starts succeeded"));
  CHECK(result.coefficients.empty());
  // What is wrong with the capture may be why.
  CHECK(text_of(result.warnings) == "capture \"a\": it has 5 frames");
}

TEST_CASE("starts at which an output or its derivative is no number say so, with output, time and capture") {
  const std::vector captures = {make_capture("a", even_times(3, 1.0), Eigen::VectorXd::Ones(3))};
  const std::string wrong = " of capture \"a\" is not a finite number";
  const std::string steep =
      "the output \"x\" at 0 s of capture \"a\" has a derivative that is not a finite number";
  FitOptions held;
  held.unknowns.fixed = {{"v0", 1.5}};
  CHECK(fit(roots(-3.0, 0.0), captures, held).message ==
        "none of 3 starts succeeded; the first: the output \"x\" at 1 s" + wrong);
  CHECK(fit(roots(-3.0, 0.0), captures).message ==
        "none of 3 starts succeeded; the first: the output \"x\" at 0.5 s" + wrong);
  held.unknowns.fixed = {{"v0", 0.0}};
  CHECK(fit(roots(2.0, 0.0), captures, held).message == "none of 3 starts succeeded; the first: " + steep);

  SECTION("which does not keep other starts from succeeding") {
    const FitResult result = fit(roots(2.0, -2.0), captures);
    CHECK(result.is_usable());
    CHECK(result.starts.front().message == steep);
  }
}

TEST_CASE(
    "what is strange about captures is said by their names, also where the fit fails, and notes are no "
    "warnings") {
  const std::vector<double> times = even_times(10, 1.0);
  std::vector<Capture> captures;
  for (const char* id : {"a", "b"}) captures.push_back(make_capture(id, times, Eigen::VectorXd::Zero(10)));
  captures[0].notes = {"a note"};
  FitOptions options;
  options.starts.count = 1;
  for (const bool fails : {false, true}) {
    const FitResult result =
        fails ? fit(BrokenFamily(false), captures, options) : fit(BrakedFamily(), captures, options);
    CHECK((result.status == samara::Termination::failed) == fails);
    CHECK_THAT(text_of(result.warnings),
               Contains("capture \"a\": x never changes over 10 frames; likewise 1 more: \"b\""));
    CHECK_THAT(text_of(result.warnings), !Contains("a note"));
    if (!fails) CHECK(result.captures[0].notes == captures[0].notes);
  }
}

TEST_CASE("what a source throws comes out of the fit") {
  const std::vector<double> times = even_times(5, 1.0);
  const std::vector captures = {make_capture("a", times, BrakedFamily::depths(1.0, 1.0, times))};
  CHECK_THROWS_AS(fit(BrokenFamily(true), captures), samara::ArgumentError);
}

namespace {

/// x = p^2 t + p t^2/5: much the same path for p and -p.
class TwoStraightValleys final : public samara::models::TrajectoryFamily {
 public:
  TwoStraightValleys() {
    info_.model = "two valleys";
    info_.source = "closed form";
    info_.coordinates = {{"p", "1", false, -2.0, 2.1}};
    info_.outputs = {{"x", "m"}};
  }
  const samara::models::FamilyInfo& info() const override { return info_; }
  std::unique_ptr<samara::models::TrajectorySource> at(const std::vector<double>& times,
                                                       const std::vector<std::string>&) const override {
    struct Source final : samara::models::TrajectorySource {
      samara::models::TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                                 Eigen::MatrixXd* derivatives) override {
        for (std::size_t row = 0; row < times.size(); ++row) {
          const double t = times[row];
          const auto at = static_cast<Eigen::Index>(row);
          values(at, 0) = q[0] * q[0] * t + 0.2 * q[0] * t * t;
          if (derivatives) (*derivatives)(at, 0) = 2.0 * q[0] * t + 0.2 * t * t;
        }
        return {};
      }
      std::vector<double> times;
    };
    auto source = std::make_unique<Source>();
    source->times = times;
    return source;
  }

 private:
  samara::models::FamilyInfo info_;
};

}  // namespace

TEST_CASE("another optimum of nearly the same cost is reported, not hidden") {
  const TwoStraightValleys family;
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.starts.count = 6;
  // By scanning p: minima of 1/2 sum (x - measured)^2 are 1.5451e-3 at p = -1.0781 and 1.6522e-3, 6.9 % more,
  // at p = 0.9113.
  const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(5, 0.0, 1.0);
  const std::vector captures = {make_capture("a", even_times(5, 1.0), (t - 0.02 * t * t).matrix())};
  const FitResult result = fit(family, captures, options);
  CHECK_THAT(result.coefficients[0].value, Catch::Matchers::WithinAbs(-1.0781, 1e-3));
  CHECK(result.starts_at_best > 0);
  CHECK(result.starts_at_best < 6);
  CHECK_THAT(text_of(result.warnings),
             Contains("ended in another optimum, p = 0.911") && Contains("6.9 % higher"));
}
