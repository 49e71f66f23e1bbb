/// Fits of captures that are cut into segments: where something is missing, held, or little.
#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/starts/start_point.h"
#include "samara/identification/solve/starts/states_from_frames.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/ambient_flow.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "spoilt_family.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using samara::models::find_model;

namespace {

/// The middle of the box of shared unknowns.
Eigen::VectorXd centre(const FitProblem& problem) {
  Eigen::VectorXd shared(problem.shared_count());
  for (int k = 0; k < problem.shared_count(); ++k) {
    const samara::models::FamilyCoordinate& c = problem.shared[static_cast<std::size_t>(k)];
    shared[k] = 0.5 * (c.lower + c.upper);
  }
  return shared;
}

FitOptions in_segments(double length) {
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.segments.length = length;
  options.starts.count = 1;
  return options;
}

/// The coin's start may lie anywhere.
std::unique_ptr<samara::models::TrajectoryFamily> placed_coin_family() {
  return reference_trajectories(find_model("vertical_fall"), coin_fixed(),
                                {{"C_D", {0.6, 2.0}}, {"v(0)", {-0.4, 0.8}}, {"x(0)", {-1.0, 1.0}}});
}

const Nuisance& nuisance(const FitResult& result, std::size_t capture, const std::string& name) {
  const auto& all = result.captures.at(capture).nuisances;
  const auto found = std::ranges::find(all, name, &Nuisance::name);
  REQUIRE(found != all.end());
  return *found;
}

const std::map<std::string, double>& plate_body() {
  static const std::map<std::string, double> values = {{"a", 0.05},        {"b", 0.03},   {"c", 0.001},
                                                       {"density", 200.0}, {"C_D0", 0.1}, {"C_T", 1.0},
                                                       {"C_R", 1.0},       {"C_w", 1.0}};
  return values;
}

std::map<std::string, samara::models::Interval> body_box() {
  std::map<std::string, samara::models::Interval> box = {{"C_D90", {0.5, 2.0}}};
  for (const char* name : {"qw(0)", "qx(0)", "qy(0)", "qz(0)"}) box[name] = {-1.0, 1.0};
  for (const char* name : {"ux(0)", "uy(0)", "uz(0)"}) box[name] = {-1.0, 1.0};
  for (const char* name : {"wx(0)", "wy(0)", "wz(0)"}) box[name] = {-5.0, 5.0};
  return box;
}

std::unique_ptr<samara::models::TrajectoryFamily> body_family() {
  return step_trajectories(find_model("immersed_body"), plate_body(), body_box(), 2e-3);
}

/// A plate that falls flat and begins to turn, with its attitude.
Capture body_capture(int frames) {
  std::map<std::string, double> values = plate_body();
  values["C_D90"] = 1.2;
  values["uz(0)"] = -0.3;
  values["wx(0)"] = 2.0;
  const samara::models::ParametricModel model(find_model("immersed_body"), values, {});
  const std::vector<double> times = even_times(frames, 0.3);
  const auto trajectory = samara::models::integrate(model, {}, times);
  Capture capture = make_capture("body", times, trajectory.states.col(0));
  const std::vector<std::string> names = {"x", "y", "z", "qw", "qx", "qy", "qz"};
  for (std::size_t k = 1; k < names.size(); ++k) {
    capture.channels.push_back({names[k], k < 3 ? "m" : "1", trajectory.states.col(static_cast<int>(k))});
  }
  return capture;
}

}  // namespace

TEST_CASE("a search of the box needs nothing that is the captures' own") {
  const std::vector captures = {coin_capture("a", 1.2, 0.1, 0.0)};
  FitOptions options;
  options.starts.count = 1;
  options.unknowns.fixed = {{"v(0)", 0.1}};
  options.unknowns.offsets = std::vector<std::string>{};
  options.starts.global = {.method = GlobalMethod::controlled_random, .budget = 20};
  const FitResult result = fit(*coin_family(), captures, options);
  CHECK(result.global_search->evaluations == 20);
  CHECK_THAT(result.coefficients.at(0).value, WithinRel(1.2, 1e-6));
}

TEST_CASE("a parameter of each capture's own is one number over its segments") {
  const std::vector captures = {coin_capture("a", 1.0, 0.1, 0.0), coin_capture("b", 1.5, 0.2, 0.0)};
  FitOptions options = in_segments(0.15);
  options.unknowns.per_capture = {"C_D"};
  const FitResult result = fit(*coin_family(), captures, options);
  INFO(result.message);
  REQUIRE(result.captures.at(0).segments == 3);
  CHECK(result.join_defect.value() < 1e-3);
  // Exact but for what the penalty leaves.
  CHECK_THAT(nuisance(result, 0, "C_D").value, WithinRel(1.0, 1e-4));
  CHECK_THAT(nuisance(result, 1, "C_D").value, WithinRel(1.5, 1e-4));
}

TEST_CASE("segments are refused if each would begin at the same place") {
  const std::vector captures = {coin_capture("a", 1.2, 0.1, 0.0)};
  FitOptions options = in_segments(0.15);
  options.unknowns.offsets = std::vector<std::string>{};
  CHECK_THROWS_WITH(fit(*coin_family(), captures, options),
                    Contains("of \"x\" each would start at the same value") && Contains("offsets"));
  options.unknowns.shared = {"x(0)"};
  CHECK_THROWS_WITH(fit(*placed_coin_family(), captures, options), Contains("a box for \"x(0)\""));
  // One segment has nothing to join.
  options.segments.length = 1.0;
  CHECK(fit(*placed_coin_family(), captures, options).status == samara::Termination::converged);
}

TEST_CASE("offsets of segments join from the start that is known of the capture") {
  Capture capture = coin_capture("a", 1.2, 0.1, 0.05);
  capture.labels["release"] = "0.5";
  FitOptions options = in_segments(0.15);
  options.unknowns.known = {{"x(0)", "release"}};
  options.unknowns.offsets = {{"x"}};
  const FitResult result = fit(*placed_coin_family(), std::vector{capture}, options);
  CHECK(result.join_defect.value() < 1e-3);
  CHECK_THAT(result.coefficients.at(0).value, WithinRel(1.2, 1e-4));
  CHECK_THAT(nuisance(result, 0, "offset of x").value, WithinAbs(0.05 - 0.5, 1e-5));
}

TEST_CASE("where all segments start does not open their joins") {
  FitOptions options = in_segments(0.2);
  options.unknowns.shared = {"x(0)"};
  options.unknowns.offsets = {{"x"}};
  const auto family = placed_coin_family();
  const FitProblem problem =
      make_problem(family->info(), std::vector{coin_capture("a", 1.2, 0.1, 0.0)}, options);
  SegmentResidual residual(*family, problem, problem.segments.at(0));
  Eigen::VectorXd shared = centre(problem);
  const Eigen::VectorXd own = Eigen::Vector2d(0.1, 0.3);
  const auto joins = [&] {
    REQUIRE(residual.evaluate(shared.data(), own.data(), own.data(), true));
    return Eigen::VectorXd(residual.residual().tail(residual.join_size()));
  };
  const Eigen::VectorXd before = joins();
  CHECK(residual.by_shared().bottomRightCorner(2, 1).norm() < 1e-12);  // by x(0), the last
  shared[1] += 0.4;
  CHECK((joins() - before).norm() < 1e-9);
}

TEST_CASE("what a capture shows in few frames only is no reason to give up") {
  std::vector captures = {coin_capture("a", 1.2, 0.1, 0.0), coin_capture("b", 1.2, 0.2, 0.0)};
  // Smoothing takes four frames at least.
  captures[1].channels[0].values.tail(22).setConstant(std::nan(""));
  for (Capture& capture : captures) {
    capture.channels.push_back({"v", "m/s", Eigen::VectorXd::Constant(25, std::nan(""))});
  }
  captures[0].channels[1].values[0] = 0.1;
  FitOptions options = in_segments(1.0);
  options.loss.scales = {{"v", 0.01}};
  const FitResult result = fit(*coin_family(), captures, options);
  CHECK_THAT(result.coefficients.at(0).value, WithinRel(1.2, 1e-4));
  CHECK_THAT(nuisance(result, 1, "v(0)").value, WithinAbs(0.2, 1e-4));
}

TEST_CASE("two frames at one time are refused where captures are cut, and named") {
  Capture capture = coin_capture("a", 1.2, 0.1, 0.0);
  capture.times[7] = capture.times[6];
  CHECK_THROWS_WITH(fit(*coin_family(), std::vector{capture}, in_segments(0.15)),
                    Contains("capture \"a\" has a frame at 0.1") && Contains("s after one at 0.1"));
}

TEST_CASE("first offsets count from where the equations start") {
  std::map<std::string, double> held = coin_fixed();
  held["x(0)"] = 0.5;
  const auto family =
      reference_trajectories(find_model("vertical_fall"), held, {{"C_D", {0.6, 2.0}}, {"v(0)", {-0.4, 0.8}}});
  const FitProblem problem =
      make_problem(family->info(), std::vector{coin_capture("a", 1.3, 0.1, 0.05)}, in_segments(1.0));
  const auto starts = states_from_frames(*family->equations(), problem, problem.motions.at(0),
                                         Eigen::VectorXd::Constant(1, 1.3), {.degree = 4, .frames = 15});
  // A polynomial through 15 frames of 17 ms each.
  CHECK_THAT(starts.at(0)[1], WithinAbs(0.05 - 0.5, 1e-4));
}

TEST_CASE("a start attitude is the first one measured, or one without a turn, and always of unit length") {
  const auto family = body_family();
  Capture capture = body_capture(20);
  const auto attitude = [&](int index) {
    const FitProblem problem = make_problem(family->info(), std::vector{capture}, {});
    std::vector<SegmentResidual> residuals;
    residuals.emplace_back(*family, problem, problem.segments.at(0));
    return Eigen::Vector4d(
        start_point(problem, residuals, index).own.at(0).segment<4>(static_cast<int>(*problem.own_attitude)));
  };
  for (const int index : {1, 2, 3, 4}) CHECK_THAT(attitude(index).norm(), WithinAbs(1.0, 1e-14));
  for (int k = 3; k < 7; ++k) capture.channels[static_cast<std::size_t>(k)].values[0] = 0.5;
  CHECK((attitude(0) - Eigen::Vector4d::Constant(0.5)).norm() < 1e-14);
  capture.channels.resize(3);
  CHECK((attitude(0) - Eigen::Vector4d(1.0, 0.0, 0.0, 0.0)).norm() < 1e-14);
}

TEST_CASE("an attitude that is free in part is fitted, but not cut into segments") {
  std::map<std::string, double> held = plate_body();
  held["qw(0)"] = 1.0;
  held["qz(0)"] = 0.0;
  std::map<std::string, samara::models::Interval> box = body_box();
  box.erase("qw(0)");
  box.erase("qz(0)");
  const auto family = step_trajectories(find_model("immersed_body"), held, box, 2e-3);
  FitOptions options;
  options.starts.count = 1;
  const std::vector captures = {body_capture(20)};
  const FitResult result = fit(*family, captures, options);
  INFO(result.message);
  REQUIRE(result.status == samara::Termination::converged);
  CHECK_THAT(result.coefficients.at(0).value, WithinRel(1.2, 1e-3));  // steps of 2 ms
  CHECK_THAT(nuisance(result, 0, "qx(0)").value, WithinAbs(0.0, 1e-3));
  CHECK_THROWS_WITH(fit(*family, captures, in_segments(0.15)),
                    Contains("\"qw(0)\" is not a free coordinate of each capture"));
}

TEST_CASE("a body whose attitude is free is fitted without segments") {
  FitOptions options;
  options.starts.count = 1;
  const FitResult result = fit(*body_family(), std::vector{body_capture(20)}, options);
  INFO(result.message);
  REQUIRE(result.status == samara::Termination::converged);
  CHECK_THAT(result.coefficients.at(0).value, WithinRel(1.2, 1e-3));  // steps of 2 ms
}

TEST_CASE("values known of captures must lie in the box") {
  Capture capture = coin_capture("a", 1.2, 0.1, 0.0);
  capture.labels["drag"] = "-1";
  FitOptions options = in_segments(1.0);
  options.unknowns.known = {{"C_D", "drag"}};
  CHECK_THROWS_WITH(
      fit(*coin_family(), std::vector{capture}, options),
      Contains("capture \"a\": the label \"drag\" says that \"C_D\" is -1") && Contains("0.6 to 2"));
}

TEST_CASE("means of frames end with the family where rounding puts their last just behind it") {
  struct EndingFamily final : samara::models::TrajectoryFamily {
    BrakedFamily endless;
    const samara::models::FamilyInfo& info() const override { return endless.info(); }
    std::unique_ptr<samara::models::TrajectorySource> at(
        const std::vector<double>& times, const std::vector<std::string>& outputs) const override {
      REQUIRE(times.back() <= info().end_time);
      return endless.at(times, outputs);
    }
  } family;
  const std::vector<double> times = even_times(21, 1.0);
  const Capture capture = make_capture("a", times, BrakedFamily::depths(1.0, 1.0, times));
  // Half a mean before the first frame, half a mean after the last.
  family.endless.mutable_info().end_time = 1.1 - 1e-9;
  FitOptions options;
  options.compared.averaged_frames = 3;
  CHECK(fit(family, std::vector{capture}, options).status == samara::Termination::converged);
}

TEST_CASE("a round that leads nowhere costs iterations too, and is the last one") {
  const std::vector captures = {coin_capture("a", 1.2, 0.1, 0.0), coin_capture("b", 1.2, 0.3, 0.0)};
  FitOptions options = in_segments(1.0);
  const int one = fit(*coin_family(), captures, options).iterations;
  options.starts.rounds = 2;
  const int two = fit(*coin_family(), captures, options).iterations;
  CHECK(two >= one + 1);
  options.starts.rounds = 4;
  CHECK(fit(*coin_family(), captures, options).iterations == two);
}

TEST_CASE("segments that begin later than the equations are refused where those depend on time") {
  struct Gust final : samara::models::AmbientFlow {
    samara::models::AmbientSample sample(double t, const Eigen::Vector3d&) const override {
      return {.velocity = {std::sin(t), 0.0, 0.0}, .rate = {std::cos(t), 0.0, 0.0}};
    }
    double length() const override { return 1.0; }
  };
  const auto gusty = samara::models::immersed_body_in(std::make_shared<Gust>());
  const auto family = step_trajectories(gusty, plate_body(), body_box(), 2e-3);
  CHECK_FALSE(family->info().autonomous);
  CHECK(body_family()->info().autonomous);
  Capture capture = body_capture(20);
  CHECK_THROWS_WITH(make_problem(family->info(), std::vector{capture}, in_segments(0.15)),
                    Contains("depend on time") && Contains("capture \"body\""));
  CHECK(make_problem(family->info(), std::vector{capture}, in_segments(1.0)).segments.size() == 1);
}

namespace {

const samara::codebooks::Codebook& coin_book() {
  static const auto book = samara::codebooks::build(samara::codebooks::parse_plan(R"toml(
model = "vertical_fall"
[fixed]
area = 4.71435e-4
thickness = 2.55e-3
density = 6338.6
[box]
C_D = [0.8, 1.6]
"v(0)" = [-0.1, 0.8]
[time]
end = 0.25
[tolerance]
relative = 1e-5
)toml",
                                                                                  "plan.toml"))
                               .book;
  return book;
}

/// What says nothing but its attitude, which stays.
samara::codebooks::Codebook resting_body() {
  using samara::pgd::Axis;
  const Axis time = Axis::chebyshev({"t", "s", samara::pgd::AxisRole::time}, 0.0, 1.0, 3);
  const Axis C_D90 = Axis::p1({"C_D90", "1", samara::pgd::AxisRole::parameter}, 0.5, 2.0, 2);
  std::vector<samara::codebooks::FieldGroup> fields;
  const Eigen::Vector4d q(0.8, 0.6, 0.0, 0.0);
  const std::vector<std::string> names = {"qw", "qx", "qy", "qz"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto value = Eigen::RowVectorXd::Constant(1, q[static_cast<Eigen::Index>(k)]);
    fields.emplace_back(samara::pgd::SeparatedField(
        {time, C_D90}, {{names[k], "1"}}, {Eigen::MatrixXd::Ones(3, 1), Eigen::MatrixXd::Ones(2, 1)}, value));
  }
  samara::codebooks::ModelDescription model;
  model.name = "immersed_body";
  model.fixed = plate_body();
  return samara::codebooks::Codebook(model, {samara::codebooks::Piece(fields)});
}

}  // namespace

TEST_CASE("segments of a codebook start where the capture shows them, beyond its own end too") {
  const auto family = codebook_trajectories(coin_book());
  REQUIRE(family->equations() != nullptr);
  // 0.4 s in two segments, of a codebook of 0.25 s.
  const Capture capture = coin_capture("a", 1.2, 0.1, 0.05);
  const FitResult result = fit(*family, std::vector{capture}, in_segments(0.2));
  REQUIRE(result.captures.at(0).segments == 2);
  CHECK_THAT(result.coefficients.at(0).value, WithinRel(1.2, 1e-3));  // 1e-5 of the ranges
  CHECK_FALSE(result.warnings.has(WarningKind::segments));
}

TEST_CASE("segments of a codebook need all states among its outputs") {
  samara::models::FamilyInfo info = codebook_trajectories(coin_book())->info();
  std::erase_if(info.outputs, [](const samara::models::FamilyOutput& output) { return output.name == "v"; });
  CHECK_THROWS_WITH(make_problem(info, std::vector{coin_capture("a", 1.2, 0.1, 0.0)}, in_segments(0.2)),
                    Contains("\"v\" is not among the outputs of the codebook"));
}

TEST_CASE("segments without known equations are warned about") {
  const std::vector<double> times = even_times(21, 1.0);
  const Capture capture = make_capture("a", times, BrakedFamily::depths(1.0, 1.0, times));
  const auto warnings = fit(BrakedFamily(), std::vector{capture}, in_segments(10.0)).warnings;
  CHECK(warnings.has(WarningKind::segments, "segments began in the middle of their boxes"));
}

TEST_CASE("attitudes of a codebook are compared as turns") {
  const samara::codebooks::Codebook book = resting_body();
  const auto family = codebook_trajectories(book);
  CHECK(family->info().attitude == std::vector<std::string>{"qw", "qx", "qy", "qz"});
  Capture capture = body_capture(4);
  const Eigen::Vector4d q(-0.8, -0.6, 0.0, 0.0);  // the other sign
  for (int k = 0; k < 4; ++k) capture.channels[static_cast<std::size_t>(k + 3)].values.setConstant(q[k]);
  const FitProblem problem = make_problem(family->info(), std::vector{capture}, {});
  SegmentResidual residual(*family, problem, problem.segments.at(0));
  REQUIRE(residual.evaluate(centre(problem).data(), nullptr, nullptr, false));
  CHECK(residual.residual().norm() < 1e-12);
}

TEST_CASE("a joined fit to what is no number fails, and says where") {
  const std::vector captures = {coin_capture("a", 1.2, 0.1, 0.0)};
  FitOptions options = in_segments(0.15);
  options.starts.count = 2;
  const auto coin = coin_family();
  const auto message = [&](const std::string& output, double from, SpoiltFamily::Part part) {
    const FitResult result = fit(SpoiltFamily(*coin, output, from, part), captures, options);
    CHECK(result.status == samara::Termination::failed);
    return result.message;
  };
  CHECK(message("x", 0.04, SpoiltFamily::Part::values) ==
        "none of 2 starts succeeded; the first: the output \"x\" at 0.05 s of capture \"a\" is not a finite "
        "number");
  CHECK(message("x", 0.04, SpoiltFamily::Part::derivatives) ==
        "none of 2 starts succeeded; the first: the output \"x\" at 0.05 s of capture \"a\" has a derivative "
        "that is not a finite number");
  CHECK_THAT(message("v", 0.0, SpoiltFamily::Part::values),
             Contains("the first: the end of a segment at 0.1") && Contains("s of capture \"a\""));
}
