#include "samara/identification/problem/segment_residual.h"

#include <catch2/catch.hpp>

#include "samara/models/trajectories/step_trajectories.h"
#include "spoilt_family.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::WithinAbs;

namespace {

/// Largest difference between a column of derivatives and central differences of step h, in residuals over
/// the given range of the unknown.
void check_gradient(SegmentResidual& residual, const Eigen::VectorXd& shared, const Eigen::VectorXd& own) {
  REQUIRE(residual.evaluate(shared.data(), own.data(), nullptr, true));
  const Eigen::MatrixXd by_shared = residual.by_shared();
  const Eigen::MatrixXd by_own = residual.by_own();
  const auto differences = [&](bool of_shared, Eigen::Index k, double h) {
    Eigen::VectorXd s = shared;
    Eigen::VectorXd o = own;
    (of_shared ? s : o)[k] += h;
    REQUIRE(residual.evaluate(s.data(), o.data(), nullptr, false));
    const Eigen::VectorXd up = residual.residual();
    (of_shared ? s : o)[k] -= 2.0 * h;
    REQUIRE(residual.evaluate(s.data(), o.data(), nullptr, false));
    return Eigen::VectorXd((up - residual.residual()) / (2.0 * h));
  };
  // Residuals are up to 200 (0.4 m over 2 mm) with an error of 1e-10 relative and more, over h = 1e-4; the
  // truncation h^2/6 times third derivatives of a few hundred is smaller.
  for (Eigen::Index k = 0; k < shared.size(); ++k) {
    CHECK((by_shared.col(k) - differences(true, k, 1e-4)).cwiseAbs().maxCoeff() < 1e-3);
    CHECK(by_shared.col(k).cwiseAbs().maxCoeff() > 1.0);
  }
  for (Eigen::Index k = 0; k < own.size(); ++k) {
    CHECK((by_own.col(k) - differences(false, k, 1e-4)).cwiseAbs().maxCoeff() < 1e-3);
    CHECK(by_own.col(k).cwiseAbs().maxCoeff() > 1.0);
  }
}

}  // namespace

TEST_CASE("residuals are (model + offset - measured) over the loss scale, missing frames left out") {
  const BrakedFamily family;
  const std::vector<double> times = {0.0, 0.5, 1.0, 1.5};
  Capture capture = make_capture("a", times, Eigen::Vector4d(0.0, 1.0, std::nan(""), 2.0));
  FitOptions options;
  options.loss.length_scale = 0.5;
  const FitProblem problem = make_problem(family.info(), std::vector{capture}, options);
  REQUIRE(problem.segments[0].times == std::vector<double>{0.0, 0.5, 1.5});
  SegmentResidual residual(family, problem, problem.segments[0]);
  const double k = 1.3;
  const Eigen::Vector2d own(0.7, 0.25);  // v(0), offset of x
  REQUIRE(residual.evaluate(&k, own.data(), nullptr, false));
  REQUIRE(residual.size() == 3);
  CHECK_THAT(residual.residual()[0], WithinAbs(0.25 / 0.5, 1e-14));
  CHECK_THAT(residual.residual()[2], WithinAbs((BrakedFamily::depth(k, 0.7, 1.5) + 0.25 - 2.0) / 0.5, 1e-14));

  SECTION("and offsets can be centred") {
    Eigen::VectorXd moved = own;
    residual.centre_offsets(moved);
    REQUIRE(residual.evaluate(&k, moved.data(), nullptr, false));
    CHECK_THAT(residual.residual().sum(), WithinAbs(0.0, 1e-13));
    CHECK(moved[0] == own[0]);
  }
}

TEST_CASE("derivatives of the residuals agree with finite differences") {
  const auto family = coin_family();
  Capture capture = coin_capture("a", 1.1, 0.05, 0.2);
  capture.channels[0].values[7] = std::nan("");
  SECTION("of shared and own unknowns") {
    const FitProblem problem = make_problem(family->info(), std::vector{capture}, {});
    SegmentResidual residual(*family, problem, problem.segments[0]);
    check_gradient(residual, Eigen::VectorXd::Constant(1, 1.3), Eigen::Vector2d(0.2, 0.1));
  }
  SECTION("when everything is the capture's own") {
    FitOptions options;
    options.unknowns.per_capture = {"C_D"};
    const FitProblem problem = make_problem(family->info(), std::vector{capture}, options);
    SegmentResidual residual(*family, problem, problem.segments[0]);
    check_gradient(residual, Eigen::VectorXd(), Eigen::Vector3d(1.3, 0.2, 0.1));
  }
  SECTION("when everything is shared, and a coordinate is held") {
    FitOptions options;
    options.unknowns.shared = {"v(0)"};
    options.unknowns.fixed = {{"C_D", 1.0}};
    options.unknowns.offsets = std::vector<std::string>{};
    const FitProblem problem = make_problem(family->info(), std::vector{capture}, options);
    SegmentResidual residual(*family, problem, problem.segments[0]);
    check_gradient(residual, Eigen::VectorXd::Constant(1, 0.2), Eigen::VectorXd());
  }
}

TEST_CASE("two outputs stand in one residual, each over its own scale") {
  const auto family = coin_family();
  Capture capture = coin_capture("a", 1.1, 0.05, 0.2);
  capture.channels.push_back({"v", "m/s", Eigen::VectorXd::LinSpaced(25, 0.05, 0.4)});
  FitOptions options;
  options.loss.scales = {{"v", 1e-2}};
  const FitProblem problem = make_problem(family->info(), std::vector{capture}, options);
  REQUIRE(problem.requested == std::vector<std::string>{"v", "x"});
  SegmentResidual residual(*family, problem, problem.segments[0]);
  CHECK(residual.size() == 50);
  check_gradient(residual, Eigen::VectorXd::Constant(1, 1.3), Eigen::Vector2d(0.2, 0.1));
  const double C_D = 1.1;
  const Eigen::Vector2d own(0.05, 0.2);
  REQUIRE(residual.evaluate(&C_D, own.data(), nullptr, false));
  CHECK_THAT(residual.residual()[0], WithinAbs(0.0, 1e-9));  // v(0), over 1 cm/s
  CHECK_THAT(residual.residual()[1], WithinAbs(0.0, 1e-9));
}

TEST_CASE("segments of equally spaced frames have the same times to the last bit") {
  // Thirds are not exact in binary: differences of these times are not the same numbers.
  Capture capture = make_capture("a", even_times(61, 20.0 / 3.0), Eigen::VectorXd::Zero(61));
  capture.times.array() += 1.0 / 3.0;
  Capture uneven = capture;
  uneven.id = "b";
  uneven.times.tail(60).array() += 1e-6;
  FitOptions options;
  options.segments.length = 1.0 / 3.0;
  const FitProblem problem = make_problem(BrakedFamily().info(), std::vector{capture, uneven}, options);
  REQUIRE(problem.segments.size() == 40);
  // All but the first of the uneven one; the last of each ends at a frame where others end at their join.
  int same = 0;
  for (const Segment& segment : problem.segments) same += segment.times == problem.segments[0].times ? 1 : 0;
  CHECK(same == 39);
  CHECK(problem.segments[20].times[1] - problem.segments[0].times[1] == Approx(1e-6).epsilon(1e-6));
}

TEST_CASE("what is no number in a residual is named") {
  using Part = SpoiltFamily::Part;
  const auto coin = coin_family();
  const Eigen::VectorXd shared = Eigen::VectorXd::Constant(1, 1.3);
  const Eigen::VectorXd own = Eigen::Vector2d(0.1, 0.05);            // v(0), offset of x
  const std::vector captures = {coin_capture("a", 1.2, 0.1, 0.05)};  // frames every 1/60 s

  SECTION("by output and time, of a value and of a derivative") {
    const FitProblem problem = make_problem(coin->info(), captures, {});
    const SpoiltFamily no_value(*coin, "x", 0.19, Part::values);
    SegmentResidual residual(no_value, problem, problem.segments[0]);
    CHECK(residual.failure().empty());
    CHECK_FALSE(residual.evaluate(shared.data(), own.data(), nullptr, false));
    CHECK(residual.failure() == "the output \"x\" at 0.2 s of capture \"a\" is not a finite number");
    CHECK_FALSE(residual.has_residuals());
    const SpoiltFamily no_slope(*coin, "x", 0.19, Part::derivatives);
    SegmentResidual steep(no_slope, problem, problem.segments[0]);
    CHECK_FALSE(steep.evaluate(shared.data(), own.data(), nullptr, true));
    CHECK(steep.failure() ==
          "the output \"x\" at 0.2 s of capture \"a\" has a derivative that is not a finite number");
    CHECK(steep.has_residuals());
    CHECK(steep.evaluate(shared.data(), own.data(), nullptr, false));
    CHECK(steep.failure().empty());
  }
  SECTION("by the time of the capture, and where segments are joined") {
    FitOptions options;
    options.segments.length = 0.2;
    const FitProblem problem = make_problem(coin->info(), captures, options);
    REQUIRE(problem.segments.size() == 2);
    const SpoiltFamily no_value(*coin, "x", 0.09, Part::values);
    SegmentResidual second(no_value, problem, problem.segments[1]);
    CHECK_FALSE(second.evaluate(shared.data(), own.data(), nullptr, false));
    CHECK(second.failure() == "the output \"x\" at 0.3 s of capture \"a\" is not a finite number");
    // Of a segment that is joined, the speed counts at its end alone.
    const SpoiltFamily no_speed(*coin, "v", 0.0, Part::values);
    SegmentResidual first(no_speed, problem, problem.segments[0]);
    CHECK_FALSE(first.evaluate(shared.data(), own.data(), own.data(), false));
    CHECK(first.failure() == "the end of a segment at 0.2 s of capture \"a\" is not a finite number");
  }
  SECTION("where it is a prior") {
    FitOptions options;
    options.unknowns.box = {{"v(0)", {0.01, 0.8}}};
    options.priors.coordinates["v(0)"] = {.mean = 0.1, .deviation = 0.5, .logarithmic = true};
    const FitProblem problem = make_problem(coin->info(), captures, options);
    SegmentResidual residual(*coin, problem, problem.segments[0]);
    CHECK_FALSE(residual.evaluate(shared.data(), Eigen::Vector2d(0.0, 0.05).eval().data(), nullptr, false));
    CHECK(residual.failure() == "a prior of capture \"a\" is not a finite number");
  }
  SECTION("where it is an attitude") {
    // A plate at rest, whose place was not seen in the second frame.
    std::map<std::string, samara::models::Interval> box = {{"C_D90", {0.5, 2.0}}};
    const auto body = step_trajectories(samara::models::find_model("immersed_body"),
                                        {{"a", 0.05},
                                         {"b", 0.03},
                                         {"c", 0.001},
                                         {"density", 200.0},
                                         {"C_D0", 0.1},
                                         {"C_T", 1.0},
                                         {"C_R", 1.0},
                                         {"C_w", 1.0}},
                                        box, 2e-3);
    Capture capture = make_capture("plate", even_times(4, 0.03), Eigen::Vector4d::Zero());
    for (const char* name : {"y", "z"}) capture.channels.push_back({name, "m", Eigen::Vector4d::Zero()});
    capture.channels.push_back({"qw", "1", Eigen::Vector4d::Ones()});
    for (const char* name : {"qx", "qy", "qz"})
      capture.channels.push_back({name, "1", Eigen::Vector4d::Zero()});
    for (int k = 0; k < 3; ++k) capture.channels[static_cast<std::size_t>(k)].values[1] = std::nan("");
    const FitProblem problem = make_problem(body->info(), std::vector{capture}, {});
    const Eigen::VectorXd offsets = Eigen::VectorXd::Zero(problem.own_count());
    const SpoiltFamily no_value(*body, "qx", 0.015, Part::values);
    SegmentResidual residual(no_value, problem, problem.segments[0]);
    CHECK_FALSE(residual.evaluate(shared.data(), offsets.data(), nullptr, false));
    CHECK(residual.failure() ==
          "the turn to the attitude at 0.02 s of capture \"plate\" is not a finite number");
  }
}
