/// What the length of the steps does to a fit, by the fit's own account.
#include <algorithm>

#include <catch2/catch.hpp>

#include "plate_captures.h"
#include "samara/identification/fit/fit.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "synthetic.h"

using namespace samara::identification;
using samara::models::find_model;

namespace {

constexpr double kStepNoise = 1e-6;  ///< so little that steps of 0.4 matter
constexpr int kStepFrames = 16;

const std::map<std::string, double>& held() {
  static const std::map<std::string, double> values = {
      {"inertia_ratio", 1.1}, {"beta", 1.0 / 14.0}, {"B", 1.0}};
  return values;
}

/// A fluttering plate over six units of time, by CVODES.
Capture fluttering() {
  std::map<std::string, double> values = held();
  values.insert({{"C_T", 1.2}, {"C_R", 3.14159}, {"A", 1.4}, {"mu1", 0.2}});
  const std::vector<double> times = plate_times(kStepFrames, 20.0);
  return seen_plate(times, plate_states(values, times), kStepNoise, 5);
}

FitResult fit_with(double step, double segment) {
  auto fixed = held();
  fixed.insert({{"C_T", 1.2}, {"mu1", 0.2}});
  std::map<std::string, samara::models::Interval> box = {{"C_R", {1.0, 6.0}}, {"A", {0.5, 4.0}}};
  for (const char* name : {"vx(0)", "vy(0)", "w(0)"}) box[name] = {-8.0, 8.0};
  box["theta(0)"] = {-60.0, 60.0};
  FitOptions options;
  options.loss = {.kind = LossKind::none,
                  .scales = {{"x", kStepNoise}, {"y", kStepNoise}, {"theta", kStepNoise}}};
  options.segments.length = segment;
  options.starts.count = 1;
  return fit(*step_trajectories(find_model("falling_plate_nd"), fixed, box, step), std::vector{fluttering()},
             options);
}

bool warns(const FitResult& result) {
  return result.warnings.has(WarningKind::steps, "steps of the integration are too long");
}

}  // namespace

TEST_CASE("steps that are too long are warned of, with the shift that shorter ones bring") {
  const FitResult fine = fit_with(2e-3, 2.0);
  REQUIRE(fine.status == samara::Termination::converged);
  CHECK(fine.integration_shift.value() < 1e-3);
  CHECK_FALSE(warns(fine));

  for (const double segment : {2.0, 8.0}) {  // joined segments, and one alone
    const FitResult coarse = fit_with(0.5, segment);
    REQUIRE(coarse.status == samara::Termination::converged);
    CHECK(coarse.integration_shift.value() > 0.1);
    CHECK(warns(coarse));
    for (std::size_t k = 0; k < coarse.coefficients.size(); ++k) {
      const Coefficient& c = coarse.coefficients[k];
      const double actual = fine.coefficients[k].value - c.value;
      INFO(c.name << " would move by " << c.integration_shift.value() << ", and moves by " << actual);
      // Half the step leaves a sixteenth of an error of order 4, and more where steps are this long.
      CHECK(c.integration_shift.value() / actual > 0.5);
      CHECK(c.integration_shift.value() / actual < 1.5);
    }
  }
}

TEST_CASE("trajectories that are no steps of one length have no such shift") {
  std::mt19937_64 random(2);
  std::vector<Capture> captures = {coin_capture("coin", 1.15, 0.05, 0.1)};
  add_noise(captures[0], 5e-4, random);
  const FitResult result = fit(*coin_family(), captures);
  CHECK_FALSE(result.integration_shift);
  CHECK_FALSE(result.coefficients.at(0).integration_shift);
}
