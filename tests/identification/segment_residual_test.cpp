#include "samara/identification/problem/segment_residual.h"

#include <catch2/catch.hpp>

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
