#include <limits>

#include <catch2/catch.hpp>

#include "files.h"
#include "samara/identification/files/fit_files.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/models/laws/registry.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;

namespace {

const std::string kPixels = "px";
const std::string kDepth = "z";
const std::string kOther = "b";

std::vector<Capture> two_captures() {
  const std::vector<double> times = even_times(10, 1.0);
  return {make_capture("a", times, BrakedFamily::depths(1.0, 1.0, times)),
          make_capture("b", times, BrakedFamily::depths(1.0, 2.0, times))};
}

/// What a fit of the captures to the braked body says.
std::string fit_error(const FitOptions& options, const std::vector<Capture>& captures = two_captures()) {
  return error_of<samara::ArgumentError>([&] { fit(BrakedFamily(), captures, options); });
}

FitOptions with(const auto& change) {
  FitOptions options;
  change(options);
  return options;
}

}  // namespace

TEST_CASE("names of coordinates must be known, and stand in one role") {
  CHECK_THAT(fit_error(with([](FitOptions& o) { o.unknowns.shared = {"v(O)"}; })),
             Contains("did you mean \"v(0)\"?"));
  CHECK_THAT(fit_error(with([](FitOptions& o) { o.unknowns.per_capture = {"kk"}; })),
             Contains("per_capture: "));
  CHECK_THAT(fit_error(with([](FitOptions& o) {
               o.unknowns.fixed = {{"m", 1.0}};
             })),
             Contains("no free coordinate \"m\""));
  CHECK_THAT(fit_error(with([](FitOptions& o) {
               o.unknowns.box = {{"m", {0.0, 1.0}}};
             })),
             Contains("no free coordinate \"m\""));
  CHECK_THAT(fit_error(with([](FitOptions& o) {
               o.unknowns.shared = {"k"};
               o.unknowns.fixed = {{"k", 1.0}};
             })),
             Contains("\"k\" has a role already"));
  CHECK_THAT(fit_error(with([](FitOptions& o) {
               o.unknowns.fixed = {{"k", 9.0}};
             })),
             Contains("\"k\" is fixed at 9") && Contains("0.2 to 5"));
  CHECK_THAT(fit_error(with([](FitOptions& o) {
               o.unknowns.box = {{"k", {0.1, 1.0}}};
             })),
             Contains("within that of"));
  CHECK_THAT(fit_error(with([](FitOptions& o) {
               o.unknowns.fixed = {{"k", 1.0}, {"v(0)", 1.0}};
               o.unknowns.offsets = std::vector<std::string>{};
             })),
             Contains("every coordinate is fixed"));
}

TEST_CASE("what the family holds may be fixed again at the same value only") {
  const auto family = coin_family();
  const std::vector captures = {coin_capture("a", 1.0, 0.0, 0.0)};
  FitOptions options;
  options.unknowns.fixed = {{"thickness", 2.55e-3}};
  CHECK(fit(*family, captures, options).status == samara::Termination::converged);
  options.unknowns.fixed = {{"thickness", 2.6e-3}};
  CHECK_THAT(error_of<samara::ArgumentError>([&] { fit(*family, captures, options); }),
             Contains("holds it at 0.00255"));
}

TEST_CASE("outputs must be known, measured, and in the right dimension") {
  CHECK_THAT(fit_error(with([](FitOptions& o) { o.compared.outputs = {"z"}; })), Contains("no output \"z\""));
  CHECK_THAT(fit_error(with([](FitOptions& o) {
               o.compared.outputs = {"x", "x"};
             })),
             Contains("stands there twice"));
  CHECK_THAT(fit_error(with([](FitOptions& o) { o.unknowns.offsets = {"z"}; })), Contains("offsets: \"z\""));
  std::vector<Capture> captures = two_captures();
  captures[1].channels[0].unit = kPixels;
  CHECK_THAT(fit_error({}, captures),
             Contains("capture \"b\" measures \"x\" in px; m was expected") && Contains("[scale]"));
  captures[1].channels[0].quantity = kDepth;
  CHECK_THAT(fit_error({}, captures), Contains("no quantity in common"));
  CHECK_THAT(fit_error(with([](FitOptions& o) { o.compared.outputs = {"x"}; }), captures),
             Contains("capture \"b\" does not measure \"x\""));
  captures = two_captures();
  captures[0].channels[0].values[2] = std::numeric_limits<double>::infinity();
  CHECK_THAT(fit_error({}, captures), Contains("infinite"));
}

TEST_CASE("outputs that are no lengths need a loss scale") {
  const auto family = coin_family();
  Capture capture = coin_capture("a", 1.0, 0.1, 0.0);
  capture.channels[0] = {"v", "m/s", Eigen::VectorXd::LinSpaced(25, 0.1, 0.4)};
  const std::vector captures = {capture};
  CHECK_THAT(error_of<samara::ArgumentError>([&] { fit(*family, captures); }),
             Contains("\"v\" [m/s] has no loss scale"));
  FitOptions options;
  options.loss.kind = LossKind::none;
  CHECK(fit(*family, captures, options).captures[0].nuisances.size() == 1);  // no offset of v
  options.loss = {.kind = LossKind::huber, .scales = {{"v", 0.01}}};
  CHECK(fit(*family, captures, options).status == samara::Termination::converged);
}

TEST_CASE("captures must have enough frames, within the times of the family") {
  CHECK_THAT(fit_error({}, {}), Contains("there are no captures"));
  std::vector<Capture> captures = two_captures();
  for (int k = 1; k < 9; ++k) captures[0].channels[0].values[k] = std::nan("");
  CHECK_THAT(fit_error({}, captures), Contains("capture \"a\" has 2 values to compare for 2 unknowns"));
  captures = two_captures();
  captures[1].times.array() -= 0.5;
  CHECK_THAT(fit_error({}, captures), Contains("capture \"b\" has a frame at -0.5 s"));
  captures[1] = captures[0];
  CHECK(fit_error({}, captures) == "capture \"a\" is given twice; each once was expected");
  for (Capture& capture : captures) capture.file = "fall.csv";
  CHECK(error_of<samara::InputError>([&] { fit(BrakedFamily(), captures); }) ==
        "fall.csv: capture \"a\" is given twice; each once was expected");
  captures[0].file.clear();
  captures[1].id = kOther;
  captures[1].file = kOther;
  CHECK(fit_error({}, captures) == "no exception");

  BrakedFamily family;
  family.mutable_info().end_time = 0.6;
  CHECK_THAT(error_of<samara::ArgumentError>([&] { fit(family, two_captures()); }),
             Contains("lasts 1 s, but the closed form ends at 0.6 s; a `span`"));
  FitOptions options;
  options.compared.span = 0.6;
  CHECK(fit(family, two_captures(), options).captures[0].frames == 6);
}

TEST_CASE("a sidecar that no table file needs is refused, and so is a time that is none") {
  FitRequest request{.measured = two_captures(), .sidecar = "columns.toml"};
  const auto error = [&] { return error_of<samara::ArgumentError>([&] { fit_files(request); }); };
  CHECK_THAT(error(), Contains("every capture given is in memory") && Contains("\"columns.toml\""));
  request.captures = {"fall.toml"};
  CHECK_THAT(error(), Contains("every capture given is a sidecar itself"));
  request.left_out_span = 0.0;
  CHECK(error() == "left_out_span is 0 s; more than 0 was expected");
}

TEST_CASE("a frame that rounding puts just behind the end of the family belongs to it") {
  BrakedFamily family;
  family.mutable_info().end_time = 1.0;
  std::vector<Capture> captures = two_captures();
  captures[0].times[9] = 1.0 + 1e-6;
  CHECK(fit(family, captures).captures[0].frames == 10);
  captures[0].times[9] = 1.01;
  CHECK_THAT(error_of<samara::ArgumentError>([&] { fit(family, captures); }), Contains("ends at 1 s"));
}

TEST_CASE("a box must hold what was measured at the start, on a circle at any turn") {
  BrakedFamily family;
  family.mutable_info().coordinates.push_back({"x(0)", "m", true, -1.0, 1.0});
  const std::vector<double> times = even_times(10, 1.0);
  Capture capture = make_capture("a", times, BrakedFamily::depths(1.0, 1.0, times));
  capture.channels[0].values.array() += 5.0;
  FitOptions options;
  CHECK_THAT(error_of<samara::ArgumentError>([&] { fit(family, std::span(&capture, 1), options); }),
             Contains("capture \"a\" has x = 5 at 0 s") && Contains("\"x(0)\" goes from -1 to 1"));
  family.mutable_info().outputs[0].unit = "m";
  options.compared.periods = {{"x", 2.5}};
  CHECK_NOTHROW(make_problem(family.info(), std::span(&capture, 1), options));
}

TEST_CASE("a fit tells of its starts, and leaves out those that nobody waits for") {
  std::vector<std::string> told;
  FitOptions options;
  options.starts.count = 4;
  options.progress = [&](const samara::Progress& progress) {
    told.push_back(progress.stage);
    return told.size() < 3;
  };
  const FitResult result = fit(BrakedFamily(), two_captures(), options);
  CHECK(told == std::vector<std::string>{"start 1 of 4", "start 2 of 4", "start 3 of 4"});
  CHECK(result.starts.size() == 2);
  CHECK(result.is_usable());
}

TEST_CASE("steps without end are refused, and the times are asked about") {
  std::vector<Capture> captures = two_captures();
  FitOptions options;
  options.solver.step = 1e-15;
  CHECK_THAT(fit_error(options, captures), Contains("takes 2e+15 steps") && Contains("in another unit?"));
}

TEST_CASE("options outside their meaning are refused") {
  CHECK_THAT(fit_error(with([](FitOptions& o) { o.compared.span = -1.0; })), Contains("span is -1"));
  CHECK_THAT(fit_error(with([](FitOptions& o) { o.starts.count = 0; })), Contains("starts is 0"));
  CHECK_THAT(fit_error(with([](FitOptions& o) { o.solver.max_iterations = 0; })),
             Contains("max_iterations is 0"));
  CHECK_THAT(fit_error(with([](FitOptions& o) { o.loss.length_scale = 0.0; })),
             Contains("loss.length_scale is 0"));
  CHECK_THAT(fit_error(with([](FitOptions& o) {
               o.loss.scales = {{"x", -1.0}};
             })),
             Contains("the loss scale of \"x\" is -1"));
  CHECK_THAT(fit_error(with([](FitOptions& o) {
               o.loss.scales = {{"z", 1.0}};
             })),
             Contains("no output \"z\""));
  CHECK_THAT(fit_error(with([](FitOptions& o) {
               o.unknowns.box = {{"k", {1.0, 1.0}}};
             })),
             Contains("an interval with a length"));
  CHECK_THAT(fit_error(with([](FitOptions& o) {
               o.unknowns.fixed = {{"k", std::nan("")}};
             })),
             Contains("a finite number"));
  CHECK_THAT(fit_error(with([](FitOptions& o) { o.uncertainty.bootstrap.replicates = 1; })),
             Contains("bootstrap.replicates is 1; 0, or 2 or more, was expected"));
  CHECK_THAT(fit_error(with([](FitOptions& o) { o.uncertainty.cluster_by = {"drop"}; })),
             Contains("capture \"a\" has no label \"drop\""));
}

TEST_CASE("a reference family needs a box with lengths, inside the meaning of its parameters") {
  const auto model = samara::models::find_model("vertical_fall");
  const auto family_error = [&](const std::map<std::string, samara::models::Interval>& box) {
    return error_of<samara::ArgumentError>([&] { reference_trajectories(model, coin_fixed(), box); });
  };
  CHECK_THAT(family_error({}), Contains("the box is empty") || Contains("needs a value of \"C_D\""));
  CHECK_THAT(family_error({{"C_D", {1.0, 1.0}}}), Contains("an interval with a length"));
  CHECK_THAT(family_error({{"C_D", {-1.0, 1.0}}}), Contains("C_D"));
  CHECK_THAT(family_error({{"C_d", {0.5, 1.0}}}), Contains("did you mean \"C_D\"?"));
}
