/// Descents of captures that hang together by shared unknowns alone, on closed forms that they cannot meet.
#include <Eigen/QR>
#include <catch2/catch.hpp>

#include "samara/identification/fit/fit.h"
#include "samara/identification/solve/secant_model.h"
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
