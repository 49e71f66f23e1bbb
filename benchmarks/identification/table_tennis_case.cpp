/// A table tennis ball: drag and Magnus coefficients from flights with labelled spin, and flights predicted
/// without labels.
#include <array>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <numbers>

#include <fmt/format.h>

#include "cases.h"
#include "real_data.h"
#include "samara/io/svg_chart.h"
#include "table_tennis.h"

namespace samara::benchmarks::identification {

namespace {

constexpr const char* kCase = "table_tennis";
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kLeastFrames = 12;
constexpr int kFolds = 5;
constexpr std::array kRotationStarts = {RotationStart{-81.0 * kDegree, 0.5},
                                        RotationStart{-7.0 * kDegree, 0.5}};

void report(const std::string& metric, double value, const std::string& unit = "1") {
  print({kBench, kCase, metric, value, unit});
}

/// Every optimum of the turn between the spin's axes and the table's that is known, with its cost. The lowest
/// is returned.
std::pair<RotationStart, FitResult> optima(const std::vector<Capture>& flights) {
  const std::vector<std::pair<std::string, RotationStart>> starts = {
      {"minus81", kRotationStarts[0]},
      {"minus7", kRotationStarts[1]},
      // Half a turn about the axis about which balls spin least, and the opposite force.
      {"mirror_minus81", {-81.0 * kDegree, -0.5, true}},
      {"mirror_minus7", {-7.0 * kDegree, -0.5, true}},
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
std::vector<SpinComparison> compare(const std::string& metric, const std::vector<Capture>& flights,
                                    const FitResult& fitted) {
  std::vector<SpinComparison> spins = compare_spins(flights, fitted);
  std::vector<double> differences;
  for (const SpinComparison& spin : spins) differences.push_back((spin.effective - spin.labelled).norm());
  report(metric, median_of(differences), "rad/s");
  return spins;
}

/// Labels beside effective spins, and the distance between them flight by flight: where labels stand in the
/// wrong rows it shows at once.
void draw(const std::filesystem::path& folder, const std::vector<SpinComparison>& labelled,
          const std::vector<SpinComparison>& shifted) {
  io::SvgPanel sizes{.title = "Sizes",
                     .x_label = "label [rad/s]",
                     .y_label = "effective spin along the label [rad/s]",
                     .series = {},
                     .with_diagonal = true,
                     .from_zero = true};
  io::SvgPanel flights{.title = "Distances",
                       .x_label = "number of the flight",
                       .y_label = "from effective spin to label [rad/s]",
                       .series = {},
                       .from_zero = true};
  const auto add = [&](const std::vector<SpinComparison>& spins, const char* name, int colour) {
    const auto count = std::ssize(spins);
    Eigen::VectorXd label(count), along(count), number(count), distance(count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const SpinComparison& spin = spins[static_cast<std::size_t>(k)];
      label[k] = spin.labelled.norm();
      along[k] = spin.effective.dot(spin.labelled) / label[k];
      number[k] = std::stod(spin.number);
      distance[k] = (spin.effective - spin.labelled).norm();
    }
    const auto points = io::SvgSeries::Kind::points;
    sizes.series.push_back({.name = name, .x = label, .y = along, .kind = points, .colour = colour});
    flights.series.push_back({.name = name, .x = number, .y = distance, .kind = points, .colour = colour});
  };
  add(labelled, "labels of their own", 0);
  add(shifted, "labels of other rows", 1);
  std::filesystem::create_directories(folder);
  const std::filesystem::path file = folder / "table_tennis_spins.svg";
  std::ofstream(file) << io::svg_charts(
      "Spin of table tennis balls across their way: what flights show, and labels", {sizes, flights}, 2);
  std::cerr << kCase << ": drew " << file << '\n';
}

/// Flights whose labels lie nearer to what they show than five times the median: a few labels of over 1000
/// rad/s belong to balls that hardly bend, and what depends on S hangs on them.
std::vector<Capture> with_fitting_labels(const std::vector<Capture>& flights,
                                         const std::vector<SpinComparison>& spins) {
  std::vector<double> distances;
  for (const SpinComparison& spin : spins) distances.push_back((spin.effective - spin.labelled).norm());
  const double limit = 5.0 * median_of(distances);
  std::vector<Capture> chosen;
  for (std::size_t k = 0; k < flights.size(); ++k) {
    if (distances[k] < limit) chosen.push_back(flights[k]);
  }
  return chosen;
}

/// Drag that grows with the spin, beside one that does not: what flights say of it, and whether it predicts
/// others better.
void try_spin_drag(const std::vector<Capture>& flights, const RotationStart& start,
                   const std::string& suffix) {
  report("flights" + suffix, static_cast<double>(flights.size()));
  for (const SpinDrag spin_drag : {SpinDrag::none, SpinDrag::fitted}) {
    const std::string which = (spin_drag == SpinDrag::fitted ? "_spin_drag" : "") + suffix;
    const FitResult fitted = fit_labelled(flights, start, spin_drag);
    report("cost" + which, fitted.cost);
    for (const char* name : {"C_D", "C_M", "magnus_saturation", "spin_drag"}) {
      if (spin_drag == SpinDrag::none && name == std::string("spin_drag")) continue;
      report(fmt::format("{}{}", name, which), value_of(fitted, name));
      report(fmt::format("{}_stderr{}", name, which), error_of(fitted, name));
    }
    report("CL_at_0.4" + which, lift_coefficient(fitted, 0.4).value);
    const Distances distances =
        predict_left_out_flights(flights, std::span(&start, 1), kFolds, {}, spin_drag);
    for (const char* predictor : {"model", "labels"}) {
      report(fmt::format("left_out_median_{}{}", predictor, which), median_of(distances.at(predictor)), "m");
      report(fmt::format("left_out_rms_{}{}", predictor, which), rms_of(distances.at(predictor)), "m");
    }
  }
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
  const auto folder = measured_set(options, kCase, "table-tennis-ball-spin");
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
  const auto labelled_spins = compare("spin_from_label", flights.labelled, fitted);
  const auto shifted_spins = compare("spin_from_label_shifted", flights.shifted, fitted);
  if (!options.pictures.empty()) draw(options.pictures, labelled_spins, shifted_spins);
  if (!options.quick) {
    try_spin_drag(flights.labelled, start, "_all_labels");
    try_spin_drag(with_fitting_labels(flights.labelled, labelled_spins), start, "_fitting_labels");
  }
  for (const auto& [name, horizon] :
       {std::pair{"prediction", Horizon{0.15, 0.30}}, std::pair{"prediction_short", Horizon{0.10, 0.20}}}) {
    const Distances labelled = predict_left_out_flights(flights.labelled, kRotationStarts, kFolds, horizon);
    const Distances shifted = predict_flights(flights.shifted, fitted, drag_only, horizon);
    report_distances(name, joined(labelled, shifted));
    report_distances(fmt::format("{}_labelled_flights", name), labelled);
  }
}

}  // namespace samara::benchmarks::identification
