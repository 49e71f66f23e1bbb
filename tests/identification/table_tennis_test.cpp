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
  std::vector<Capture> training, left_out = flights.shifted;
  for (std::size_t k = 0; k < flights.labelled.size(); ++k)
    (k % 2 == 0 ? training : left_out).push_back(flights.labelled[k]);
  const FitResult fitted = fit_labelled(training, {-81.0 * std::numbers::pi / 180.0, 0.5});
  // An independent trial without buoyancy and added mass, from all of them: 0.522 +- 0.004, C_L(0.4) = 0.229
  // +- 0.005; half of the flights leave about 0.009 and 0.011.
  CHECK(std::abs(value_of(fitted, "C_D") - 0.525) < 0.03);
  const LiftCoefficient lift = lift_coefficient(fitted, 0.4);
  CHECK(std::abs(lift.value - 0.229) < 0.035);
  CHECK(lift.standard_error < 0.025);
  CHECK(median_flight_rms(fitted) < 3.5e-3);
  // The other half, and flights whose labels stand in other rows.
  const Distances distances = predict_flights(left_out, fitted, fit_drag_only(training), {});
  CHECK(distances.at("model").size() >= 15);
  // What the last frame of a span says is taken as it is: frames after it would tell that some are wrong.
  CHECK(median_of(distances.at("model")) < 0.021);
  CHECK(median_of(distances.at("model")) < 0.5 * median_of(distances.at("parabola")));
  CHECK(median_of(distances.at("model")) < 0.4 * median_of(distances.at("drag only")));
  CHECK(rms_of(distances.at("model")) < 0.8 * rms_of(distances.at("drag only")));
}
