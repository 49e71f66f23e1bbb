#include "identification/table_tennis.h"

#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "identification/real_data.h"
#include "measured_data.h"

using namespace samara::benchmarks::identification;

TEST_CASE("table tennis: coefficients from labelled flights, and flights predicted without labels") {
  const auto folder = measured_data("table-tennis-ball-spin");
  if (folder.empty()) return;
  const Flights flights =
      read_flights(folder, std::filesystem::path(SAMARA_EXAMPLES_DIR) / "captures" / "table_tennis.toml", 12);
  CHECK(flights.labelled.size() >= 54);
  const FitResult fitted = fit_labelled(flights.labelled, {-81.0 * std::numbers::pi / 180.0, 0.5});
  // An independent trial without buoyancy and added mass: 0.522 +- 0.004, C_L(0.4) = 0.229 +- 0.005.
  CHECK(std::abs(value_of(fitted, "C_D") - 0.525) < 0.02);
  const LiftCoefficient lift = lift_coefficient(fitted, 0.4);
  CHECK(std::abs(lift.value - 0.229) < 0.02);
  CHECK(lift.standard_error < 0.02);
  // Flights whose labels stand in other rows: none of them was in the fit, nor in its making.
  const Distances distances = predict_flights(flights.shifted, fitted, fit_drag_only(flights.labelled),
                                              {.window = 0.15, .end = 0.30});
  CHECK(distances.at("model").size() >= 10);
  CHECK(rms_of(distances.at("model")) < 0.035);
  CHECK(rms_of(distances.at("model")) < 0.6 * rms_of(distances.at("parabola")));
  CHECK(rms_of(distances.at("model")) < 0.4 * rms_of(distances.at("drag only")));
}
