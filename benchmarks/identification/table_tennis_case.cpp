/// A table tennis ball: drag and Magnus coefficients from flights with labelled spin, and flights predicted
/// without labels.
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <numbers>

#include <fmt/format.h>

#include "cases.h"
#include "real_data.h"
#include "table_tennis.h"

namespace samara::benchmarks::identification {

namespace {

constexpr const char* kCase = "table_tennis";
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kLeastFrames = 12;
constexpr int kFolds = 5;

void report(const std::string& metric, double value, const std::string& unit = "1") {
  print({kBench, kCase, metric, value, unit});
}

/// Every optimum of the turn between the spin's axes and the table's that is known, with its cost. The lowest
/// is returned.
std::pair<RotationStart, FitResult> optima(const std::vector<Capture>& flights) {
  const std::vector<std::pair<std::string, RotationStart>> starts = {
      {"minus81", {-81.0 * kDegree, 0.5}},
      {"minus7", {-7.0 * kDegree, 0.5}},
      // A half turn about the axis about which balls spin least, and the opposite force.
      {"mirror_minus81", {99.0 * kDegree, -0.5}},
      {"mirror_minus7", {173.0 * kDegree, -0.5}},
  };
  std::pair<RotationStart, FitResult> best;
  for (const auto& [name, start] : starts) {
    const FitResult result = fit_labelled(flights, start);
    report("cost_" + name, result.cost);
    report("CM_" + name, value_of(result, "C_M"));
    report("CL_at_0.4_" + name, lift_coefficient(result, 0.4).value);
    for (const char* axis : {"x", "y", "z"}) {
      const std::string coordinate = std::string("spin_frame_") + axis;
      report(coordinate + "_" + name, value_of(result, coordinate), "rad");
    }
    const bool is_first = best.second.captures.empty();
    if (is_first || result.cost < best.second.cost) best = {start, result};
  }
  return best;
}

/// How far labels lie from the spins that flights show.
void compare(const std::string& metric, const std::vector<Capture>& flights, const FitResult& fitted) {
  std::vector<double> differences;
  for (const SpinComparison& spin : compare_spins(flights, fitted)) {
    differences.push_back((spin.effective - spin.labelled).norm());
    std::cerr << fmt::format(
        "spin of flight {}: effective {:7.0f} {:7.0f} {:7.0f}, label {:7.0f} {:7.0f} {:7.0f}\n", spin.number,
        spin.effective.x(), spin.effective.y(), spin.effective.z(), spin.labelled.x(), spin.labelled.y(),
        spin.labelled.z());
  }
  report(metric, median_of(differences), "rad/s");
}

Distances joined(Distances some, const Distances& others) {
  for (const auto& [name, values] : others) some[name].insert(some[name].end(), values.begin(), values.end());
  return some;
}

void report_distances(const std::string& prefix, const Distances& distances) {
  for (const auto& [name, values] : distances) {
    const std::string suffix = name == "model"       ? ""
                               : name == "drag only" ? std::string("_drag_only")
                                                     : fmt::format("_{}", name);
    report(fmt::format("{}_median{}", prefix, suffix), median_of(values), "m");
    report(fmt::format("{}_rms{}", prefix, suffix), rms_of(values), "m");
  }
  report(fmt::format("{}_flights", prefix), static_cast<double>(distances.at("model").size()));
}

}  // namespace

void table_tennis_case(const Options& options) {
  if (!options.wants(kCase)) return;
  const auto folder = measured_set(kCase, "table-tennis-ball-spin");
  if (!folder) return;
  const Flights flights = read_flights(
      *folder, std::filesystem::path(SAMARA_EXAMPLES_DIR) / "captures" / "table_tennis.toml", kLeastFrames);
  report("flights_labelled", static_cast<double>(flights.labelled.size()));
  const auto [start, fitted] = optima(flights.labelled);
  report("CD", value_of(fitted, "C_D"));
  report("CD_stderr", error_of(fitted, "C_D"));
  const LiftCoefficient lift = lift_coefficient(fitted, 0.4);
  report("CL_at_0.4", lift.value);
  report("CL_at_0.4_stderr", lift.standard_error);
  const FitResult drag_only = fit_drag_only(flights.labelled);
  report("CD_drag_only", value_of(drag_only, "C_D"));
  report("flight_rms", median_flight_rms(fitted), "m");
  report("flight_rms_drag_only", median_flight_rms(drag_only), "m");
  compare("spin_from_label", flights.labelled, fitted);
  compare("spin_from_label_shifted", flights.shifted, fitted);
  for (const auto& [name, horizon] :
       {std::pair{"prediction", Horizon{0.15, 0.30}}, std::pair{"prediction_short", Horizon{0.10, 0.20}}}) {
    const Distances labelled = predict_left_out_flights(flights.labelled, start, kFolds, horizon);
    const Distances shifted = predict_flights(flights.shifted, fitted, drag_only, horizon);
    report_distances(name, joined(labelled, shifted));
    report_distances(fmt::format("{}_labelled_flights", name), labelled);
  }
}

}  // namespace samara::benchmarks::identification
