/// Starts, profiles and replicates side by side, and what they share.
#include <catch2/catch.hpp>
#include <tbb/global_control.h>

#include "closed_form_family.h"
#include "plate_captures.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/held_fits.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/solve/minimize.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "synthetic.h"

using namespace samara::identification;

namespace {

/// On one thread, and on two.
std::vector<FitResult> with_threads(const samara::models::TrajectoryFamily& family,
                                    const std::vector<Capture>& captures, const FitOptions& options) {
  std::vector<FitResult> results;
  for (const std::size_t threads : {1, 2}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(fit(family, captures, options));
  }
  return results;
}

void check_same_bits(const FitResult& one, const FitResult& other) {
  REQUIRE(one.starts.size() == other.starts.size());
  for (std::size_t k = 0; k < one.starts.size(); ++k) {
    INFO("start " << k);
    CHECK(one.starts[k].coefficients == other.starts[k].coefficients);
    CHECK(one.starts[k].cost == other.starts[k].cost);
    CHECK(one.starts[k].iterations == other.starts[k].iterations);
  }
  CHECK(one.cost == other.cost);
  CHECK(one.covariance == other.covariance);
  CHECK(one.evaluations == other.evaluations);
  REQUIRE(one.profiles.size() == other.profiles.size());
  for (std::size_t k = 0; k < one.profiles.size(); ++k) {
    CHECK(one.profiles[k].values == other.profiles[k].values);
    CHECK(one.profiles[k].costs == other.profiles[k].costs);
  }
}

/// A motion of its own unknown s and a shared one a: y(0) = x/sqrt(w^2 + x^2) with x = s - a, y(1) = s/2. With zeros
/// measured, the cost of s has a valley at s = a, about a^2/8 high, and one at s = 0, of nearly 1/2.
class MovingValley final : public ClosedFormFamily {
 public:
  MovingValley()
      : ClosedFormFamily({.model = "moving valley",
                          .coordinates = {{"a", "1", false, -1.0, 5.0}, {"s", "1", false, -1.0, 6.0}},
                          .outputs = {{"y", "1"}}},
                         [](std::span<const double> q, double t, auto& values, auto* derivatives) {
                           constexpr double kWidth = 0.3;
                           const double x = q[1] - q[0];
                           const double root = std::hypot(kWidth, x);
                           const double slope = kWidth * kWidth / (root * root * root);
                           const bool is_first = t < 0.5;
                           values << (is_first ? x / root : 0.5 * q[1]);
                           if (derivatives)
                             *derivatives << (is_first ? -slope : 0.0), (is_first ? slope : 0.5);
                         }) {}
};

/// A tumbling plate in joined segments.
struct JoinedPlate {
  std::unique_ptr<samara::models::TrajectoryFamily> family;
  std::vector<Capture> captures;
  FitOptions options;

  JoinedPlate() {
    std::map<std::string, double> values = {{"inertia_ratio", 1.4}, {"beta", 1.0 / 14.0}, {"B", 1.0}};
    const std::map<std::string, double> held = values;
    values.insert({{"C_T", 1.2}, {"C_R", 3.14159}, {"A", 1.4}, {"mu1", 0.2}});
    const std::vector<double> times = plate_times(40, 20.0);
    captures = {seen_plate(times, plate_states(values, times), 0.02, 5)};
    family = step_trajectories(samara::models::find_model("falling_plate_nd"), held,
                               {{"A", {0.9, 2.2}},
                                {"mu1", {0.1, 0.4}},
                                {"C_T", {1.1, 1.3}},
                                {"C_R", {2.9, 3.4}},
                                {"vx(0)", {-8.0, 8.0}},
                                {"vy(0)", {-8.0, 8.0}},
                                {"w(0)", {-8.0, 8.0}},
                                {"theta(0)", {-60.0, 60.0}}},
                               0.02);
    options.loss = {.kind = LossKind::none, .scales = {{"x", 0.02}, {"y", 0.02}, {"theta", 0.02}}};
    options.unknowns.fixed = {{"C_T", 1.2}, {"C_R", 3.14159}};
    options.segments.length = 1.0;
    options.starts.count = 3;
  }
};

/// Another family, without trajectories at one value of its first coordinate.
class FailingAt final : public samara::models::TrajectoryFamily {
 public:
  FailingAt(const samara::models::TrajectoryFamily& whole, double value) : whole_(whole), value_(value) {}
  const samara::models::FamilyInfo& info() const override { return whole_.info(); }
  const samara::models::ParametricModel* equations() const override { return whole_.equations(); }
  std::unique_ptr<samara::models::TrajectorySource> at(
      const std::vector<double>& times, const std::vector<std::string>& outputs) const override {
    return std::make_unique<Source>(whole_.at(times, outputs), value_);
  }

 private:
  struct Source final : samara::models::TrajectorySource {
    Source(std::unique_ptr<samara::models::TrajectorySource> all, double at_value)
        : whole(std::move(all)), value(at_value) {}
    samara::models::TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                               Eigen::MatrixXd* derivatives) override {
      if (std::abs(q[0] - value) < 1e-9)
        return {.status = samara::models::TrajectoryStatus::not_integrated, .message = "none here"};
      return whole->evaluate(q, values, derivatives);
    }
    std::unique_ptr<samara::models::TrajectorySource> whole;
    double value;
  };

  const samara::models::TrajectoryFamily& whole_;
  double value_;
};

}  // namespace

TEST_CASE("starts and profiles of joined segments have the same bits on any number of threads") {
  JoinedPlate plate;
  plate.options.uncertainty.profiles = true;
  const auto results = with_threads(*plate.family, plate.captures, plate.options);
  CHECK(results[0].status == samara::Termination::converged);
  check_same_bits(results[0], results[1]);
}

TEST_CASE("joins are weighed by the noise that was found, also where the first start has no trajectory") {
  JoinedPlate plate;
  REQUIRE(plate.family->info().coordinates.front().name == "A");
  plate.options.starts.initial = {{"A", 1.4321}};
  plate.options.loss.scales = {{"x", 0.2}, {"y", 0.2}, {"theta", 0.2}};  // ten times the noise
  plate.options.noise.estimated = true;
  const FitResult whole = fit(*plate.family, plate.captures, plate.options);
  const FitResult without_first = fit(FailingAt(*plate.family, 1.4321), plate.captures, plate.options);
  REQUIRE(without_first.starts.front().status == samara::Termination::failed);
  CHECK(without_first.starts.front().message == "there is no trajectory");
  REQUIRE(without_first.status == samara::Termination::converged);
  CHECK_THAT(without_first.join_defect.value(), Catch::Matchers::WithinRel(whole.join_defect.value(), 0.1));
  for (std::size_t k = 0; k < whole.coefficients.size(); ++k)
    CHECK_THAT(without_first.coefficients[k].naive_standard_error.value(),
               Catch::Matchers::WithinRel(whole.coefficients[k].naive_standard_error.value(), 0.02));
}

TEST_CASE("starts, profiles and replicates of many captures have the same bits on any number of threads") {
  std::vector<Capture> captures;
  std::mt19937_64 random(3);
  for (int k = 0; k < 5; ++k) {
    const std::vector<double> times = even_times(12, 1.0);
    captures.push_back(
        make_capture(fmt::format("{}", k), times, BrakedFamily::depths(1.0, 1.0 + 0.2 * k, times)));
    add_noise(captures.back(), 1e-2, random);
  }
  FitOptions options;
  options.loss.scales = {{"x", 1e-2}};
  options.noise.estimated = true;
  options.starts.count = 6;
  options.uncertainty.profiles = true;
  options.uncertainty.bootstrap.replicates = 20;
  const auto results = with_threads(BrakedFamily(), captures, options);
  CHECK(results[0].status == samara::Termination::converged);
  check_same_bits(results[0], results[1]);
  CHECK(results[0].bootstrap->coefficients == results[1].bootstrap->coefficients);
}

TEST_CASE("a profile point is looked for in more valleys than its neighbour's") {
  const MovingValley family;
  const std::vector<double> times = {0.0, 1.0};
  Capture capture;
  capture.id = "zeros";
  capture.times = Eigen::Vector2d(0.0, 1.0);
  capture.channels.push_back({"y", "1", Eigen::Vector2d::Zero()});
  FitOptions options;
  options.loss = {.kind = LossKind::none, .scales = {{"y", 1.0}}};
  options.unknowns.per_capture = {"s"};
  const FitProblem problem = make_problem(family.info(), std::span(&capture, 1), options);
  std::vector<SegmentResidual> residuals = make_residuals(family, problem);
  const FitPoint best{.shared = Eigen::VectorXd::Zero(1), .own = {Eigen::VectorXd::Zero(1)}};
  const FitPoint neighbour{.shared = Eigen::VectorXd::Constant(1, 2.9),
                           .own = {Eigen::VectorXd::Constant(1, 2.8)}};

  FitProblem held = problem;
  held.shared_chart = problem.shared_chart.holding(0);
  FitPoint start = neighbour;
  start.shared[0] = 3.0;
  const MinimizeResult alone = minimize(held, residuals, start, 100);
  REQUIRE(alone.status == samara::Termination::converged);
  CHECK(alone.cost > 1.0);  // the valley at s = a

  HeldFits fits(family, problem, residuals, best, 0, 100);
  const auto solution = fits.solve(3.0, packed(neighbour));
  REQUIRE(solution);
  CHECK(solution->cost < 0.5);
  CHECK(std::abs(solution->point[1]) < 0.1);
  // Beside the best answer there is one start.
  const long before = fits.evaluations();
  REQUIRE(fits.solve(0.1, packed(best)));
  const long one_start = fits.evaluations() - before;
  REQUIRE(fits.solve(0.1, packed(FitPoint{.shared = Eigen::VectorXd::Constant(1, 0.1),
                                          .own = {Eigen::VectorXd::Constant(1, 0.09)}})));
  CHECK(fits.evaluations() - before > one_start);
}
