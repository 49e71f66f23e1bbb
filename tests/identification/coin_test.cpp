#include <catch2/catch.hpp>

#include "samara/codebooks/plan/plan.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/problem/fit_config.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/reference_trajectories.h"

using namespace samara::identification;

namespace {

const std::string kFolder = std::string(SAMARA_EXAMPLES_DIR) + "/coin/";

/// The model and box of the example's plan, by the reference integrator.
std::unique_ptr<samara::models::TrajectoryFamily> planned_family() {
  const auto plan = samara::codebooks::read_plan(kFolder + "plan.toml");
  std::map<std::string, samara::models::Interval> box;
  for (const auto& entry : plan.box) box[entry.name] = {entry.lower, entry.upper};
  return reference_trajectories(samara::models::find_model(plan.model), plan.fixed, box);
}

FitOptions example_options() {
  return read_fit_config(kFolder + "fit.toml",
                         config_names(samara::models::find_model("vertical_fall")->info()));
}

}  // namespace

TEST_CASE("the coin tracks are read as ten captures of five drops") {
  const std::vector<Capture> captures = read_captures(kFolder + "coin.toml");
  REQUIRE(captures.size() == 10);
  CHECK(captures[0].id == "10kc112/1");
  CHECK(captures[0].labels.at("drop") == "10kc112");
  for (const Capture& capture : captures) {
    // The source's own calibrations: 0.064 to 0.083 cm a pixel.
    const double scale = capture.channel("x").metres_per_pixel.value();
    CHECK(scale > 0.63e-3);
    CHECK(scale < 0.84e-3);
    CHECK(capture.times[0] == 0.0);
  }
}

TEST_CASE("the real coin has a C_D of 1.1 to 1.25 within 0.4 s") {
  const auto family = planned_family();
  const std::vector<Capture> captures = read_captures(kFolder + "coin.toml");
  FitOptions options = example_options();
  for (const LossKind kind : {LossKind::none, LossKind::huber, LossKind::cauchy}) {
    options.loss.kind = kind;
    const FitResult result = fit(*family, captures, options);
    INFO(to_string(kind) << ": " << result.message);
    CHECK(result.is_usable());
    CHECK(result.warnings.empty());
    const Coefficient& C_D = result.coefficients[0];
    CHECK(C_D.value > 1.1);
    CHECK(C_D.value < 1.25);
    // Drops differ far more than the noise of their frames explains.
    CHECK(C_D.standard_error.value() > 2.0 * C_D.naive_standard_error.value());
    CHECK(C_D.standard_error.value() < 0.15);
    CHECK(result.clusters == 5);
    CHECK(result.captures[0].frames == 25);
  }
}
