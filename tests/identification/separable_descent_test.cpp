/// Descents of captures that hang together by shared unknowns alone, on closed forms that they cannot meet.
#include <Eigen/QR>
#include <catch2/catch.hpp>

#include "closed_form_family.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/minimize.h"
#include "samara/identification/solve/secant_model.h"
#include "samara/identification/solve/starts/choose_start_states.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::WithinAbs;

namespace {

/// Braked motions with a wobble that the model does not have, far larger than the noise.
std::vector<Capture> wobbling_captures(int count, double wobble) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  const std::vector<double> times = even_times(25, 2.0);
  std::vector<Capture> captures;
  for (int c = 0; c < count; ++c) {
    Eigen::VectorXd x = BrakedFamily::depths(1.3, 0.6 + 0.1 * c, times);
    const double phase = normal(random);
    for (Eigen::Index k = 0; k < x.size(); ++k)
      x[k] += wobble * std::sin(4.0 * times[static_cast<std::size_t>(k)] + phase);
    captures.push_back(make_capture(fmt::format("{}", c), times, x));
    add_noise(captures.back(), 1e-3, random);
  }
  return captures;
}

/// The least squares of a capture with k held: its speed and offset are linear.
double rest_of(const Capture& capture, double k) {
  const std::vector<double> times(capture.times.begin(), capture.times.end());
  Eigen::MatrixX2d J(capture.times.size(), 2);
  J.col(0) = BrakedFamily::depths(k, 1.0, times);
  J.col(1).setOnes();
  const Eigen::VectorXd& x = capture.channels[0].values;
  return (J * J.colPivHouseholderQr().solve(x).eval() - x).squaredNorm();
}

/// Where the sum over captures is least, by golden section.
double best_k(const std::vector<Capture>& captures) {
  const auto cost = [&](double k) {
    double sum = 0.0;
    for (const Capture& capture : captures) sum += rest_of(capture, k);
    return sum;
  };
  const double ratio = 0.5 * (std::sqrt(5.0) - 1.0);
  double lower = 0.5, upper = 3.0;
  while (upper - lower > 1e-9) {
    const double a = upper - ratio * (upper - lower);
    const double b = lower + ratio * (upper - lower);
    (cost(a) < cost(b) ? upper : lower) = cost(a) < cost(b) ? b : a;
  }
  return 0.5 * (lower + upper);
}

}  // namespace

TEST_CASE("a descent ends within a hundredth of a standard error of the minimum, in few steps") {
  for (const double wobble : {0.0, 0.02, 0.1}) {
    INFO("wobble " << wobble);
    const std::vector<Capture> captures = wobbling_captures(8, wobble);
    FitOptions options;
    options.loss.kind = LossKind::none;
    options.starts.count = 3;
    options.solver.max_iterations = 25;
    const FitResult result = fit(BrakedFamily(), captures, options);
    REQUIRE(result.status == samara::Termination::converged);
    CHECK(result.starts_at_best == 3);
    const Coefficient& k = result.coefficients[0];
    CHECK_THAT(k.value, WithinAbs(best_k(captures), 0.01 * k.naive_standard_error.value()));
  }
}

TEST_CASE("outliers do not keep a descent from ending") {
  std::vector<Capture> captures = wobbling_captures(6, 0.05);
  for (Capture& capture : captures) capture.channels[0].values[7] += 0.5;
  FitOptions options;
  options.solver.max_iterations = 25;
  for (const LossKind kind : {LossKind::huber, LossKind::soft_l1, LossKind::cauchy}) {
    INFO(to_string(kind));
    options.loss = {.kind = kind, .length_scale = 0.01};
    const FitResult first = fit(BrakedFamily(), captures, options);
    REQUIRE(first.status == samara::Termination::converged);
    if (kind == LossKind::cauchy) continue;  // which has other optima
    // From where it ended there is nowhere to go.
    FitOptions again = options;
    again.starts.count = 1;
    again.starts.initial["k"] = first.coefficients[0].value;
    const FitResult second = fit(BrakedFamily(), captures, again);
    CHECK_THAT(
        second.coefficients[0].value,
        WithinAbs(first.coefficients[0].value, 0.02 * first.coefficients[0].naive_standard_error.value()));
  }
}

TEST_CASE("what a model of the Hessian learned is true along the last step, and symmetric") {
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  Eigen::Matrix3d J;
  Eigen::Matrix3d rest;
  for (double& value : J.reshaped()) value = normal(random);
  for (double& value : rest.reshaped()) value = 0.05 * normal(random);
  const Eigen::Matrix3d gauss_newton = J.transpose() * J + Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d hessian = gauss_newton + rest + rest.transpose();
  SecantModel model;
  model.move_to(gauss_newton);
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d step(normal(random), normal(random), normal(random));
    model.learn(step, hessian * step);
    CHECK((model.hessian() * step - hessian * step).norm() < 1e-12 * hessian.norm());
    CHECK((model.hessian() - model.hessian().transpose()).norm() < 1e-12 * hessian.norm());
  }
  // A gradient that changes by more than twice what J^T J has is a kink.
  const Eigen::Vector3d step = Eigen::Vector3d::UnitX();
  model.learn(step, 3.0 * gauss_newton * step);
  CHECK_FALSE(model.has_learned());
}

namespace {

/// Half of sqrt(t) was measured of sqrt(v0 + t): the less v0, the better, and at 0 the slope at t = 0 is infinite.
struct EdgeOfRoot {
  ClosedFormFamily family = roots(0.5, 0.0);
  FitProblem problem;

  EdgeOfRoot() {
    const std::vector<double> times = even_times(6, 1.0);
    Eigen::VectorXd x(6);
    for (Eigen::Index k = 0; k < 6; ++k) x[k] = 0.5 * std::sqrt(times[static_cast<std::size_t>(k)]);
    FitOptions options;
    options.loss = {.kind = LossKind::none, .scales = {{"x", 0.1}}};
    options.unknowns.fixed = {{"k", 1.0}};
    problem = make_problem(family.info(), std::vector{make_capture("a", times, x)}, options);
  }

  /// 1/2 sum ((sqrt(v0 + t) - sqrt(t)/2)/0.1)^2
  static double cost(double v0) {
    double sum = 0.0;
    for (const double t : even_times(6, 1.0)) sum += std::pow(std::sqrt(v0 + t) - 0.5 * std::sqrt(t), 2);
    return 50.0 * sum;
  }
};

}  // namespace

TEST_CASE("a step to where the cost is lower but a slope infinite is shortened") {
  EdgeOfRoot of;
  std::vector<SegmentResidual> residuals = make_residuals(of.family, of.problem);
  const Eigen::VectorXd start = Eigen::VectorXd::Ones(1);
  const auto has_slopes = [&](const Eigen::VectorXd& own) {
    return residuals[0].evaluate(nullptr, own.data(), nullptr, true);
  };
  REQUIRE_FALSE(has_slopes(Eigen::VectorXd::Zero(1)));
  REQUIRE(residuals[0].evaluate(nullptr, Eigen::VectorXd::Zero(1).eval().data(), nullptr, false));

  SECTION("by a descent") {
    const MinimizeResult result =
        minimize(of.problem, residuals, {.shared = Eigen::VectorXd(0), .own = {start}}, 100);
    INFO(result.point.own[0]);
    CHECK(result.status == samara::Termination::converged);
    CHECK(has_slopes(result.point.own[0]));
    CHECK(result.cost == Approx(EdgeOfRoot::cost(result.point.own[0][0])));
    CHECK(result.cost < EdgeOfRoot::cost(0.01));
  }
  SECTION("by what chooses start states") {
    Eigen::VectorXd own = start;
    const double cost = minimize_own(of.problem, residuals[0], Eigen::VectorXd(), own, 6, 20);
    INFO(own);
    CHECK(has_slopes(own));
    CHECK(cost == Approx(EdgeOfRoot::cost(own[0])));
    CHECK(cost < EdgeOfRoot::cost(0.01));
  }
}
