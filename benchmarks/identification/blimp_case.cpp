/// A miniature blimp: 21 coefficients from eight flights, and four others predicted.
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "blimp.h"
#include "cases.h"
#include "real_data.h"
#include "samara/pgd/tensors/random.h"

namespace samara::benchmarks::identification {

namespace {

constexpr const char* kCase = "blimp";

void report(const std::string& metric, double value, const std::string& unit = "1") {
  print({kBench, kCase, metric, value, unit});
}

std::string with_underscores(std::string text) {
  for (char& c : text) c = c == ' ' ? '_' : c;
  return text;
}

std::vector<BlimpFlight> kind_of(const std::vector<BlimpFlight>& flights, bool spirals) {
  std::vector<BlimpFlight> chosen;
  for (const BlimpFlight& flight : flights) {
    if (flight.is_spiral == spirals) chosen.push_back(flight);
  }
  return chosen;
}

/// The model fitted, as its makers have it, and without physics.
/// @returns per horizon, the model's median error of position, the best baseline, and its median over that
std::vector<Measurement> report_predictions(const std::vector<BlimpFlight>& left_out,
                                            const Coefficients& fitted, const std::string& suffix) {
  std::vector<Measurement> best;
  for (const bool spirals : {false, true}) {
    const std::vector<BlimpFlight> flights = kind_of(left_out, spirals);
    for (const double ahead : {1.0, 2.0}) {
      const std::string name = fmt::format("{}{:.0f}s", spirals ? "spiral" : "straight", ahead);
      const auto print_errors = [&](const BlimpErrors& errors, const std::string& predictor) {
        report(fmt::format("{}_position{}{}", name, predictor, suffix), rms_of(errors.position), "m");
        report(fmt::format("{}_pitch{}{}", name, predictor, suffix), rms_of(errors.pitch), "rad");
      };
      const auto predictions = predict_blimp(flights, fitted, ahead);
      for (const auto& [predictor, errors] : predictions)
        print_errors(errors, predictor == "model" ? "" : fmt::format("_{}", with_underscores(predictor)));
      Measurement nearest{kBench, kCase, fmt::format("best_baseline_{}{}", name, suffix),
                          median_of(predictions.at("model").position), "m"};
      for (const auto& [predictor, errors] : predictions) {
        const double ratio = median_of(errors.position) / nearest.value;
        if (predictor == "model" || ratio >= nearest.ratio.value_or(INFINITY)) continue;
        nearest.baseline = predictor;
        nearest.ratio = ratio;
      }
      print(nearest);
      best.push_back(nearest);
      print_errors(predict_blimp(flights, makers_coefficients(), ahead).at("model"), "_makers");
    }
  }
  return best;
}

/// Halves with a spiral each, drawn at random.
Claims claims_of_halves(const std::vector<BlimpFlight>& flights, int splits) {
  std::vector<int> spirals, straights;
  for (const BlimpFlight& flight : flights) (flight.is_spiral ? spirals : straights).push_back(flight.number);
  pgd::Random random(1);
  Claims claims;
  for (int split = 0; split < splits; ++split) {
    std::vector<int> half;
    for (std::vector<int>* kind : {&spirals, &straights}) {
      for (std::size_t k = kind->size() - 1; k > 0; --k) {
        std::swap((*kind)[k],
                  (*kind)[static_cast<std::size_t>(random.uniform() * static_cast<double>(k + 1))]);
      }
      half.insert(half.end(), kind->begin(), kind->begin() + std::ssize(*kind) / 2);
    }
    const BlimpSplit halves = split_blimp(flights, half);
    claims.add_halves(fit_blimp(halves.training), fit_blimp(halves.left_out));
  }
  return claims;
}

}  // namespace

void blimp_case(const Options& options) {
  const auto folder = measured_set(options, kCase, "blimp-rgblimp-mocap");
  if (!folder) return;
  const std::vector<BlimpFlight> flights =
      read_blimp(*folder, std::filesystem::path(SAMARA_EXAMPLES_DIR) / "captures" / "blimp.toml");
  const BlimpSplit split = split_blimp(flights, {98, 126, 132, 138});
  const FitResult fitted = fit_blimp(split.training);
  report("time", fitted.seconds, "s");
  report("iterations", fitted.iterations);
  report("cost", fitted.cost);
  report("cost_from_makers", fit_blimp(split.training, AddedMass::none, makers_coefficients()).cost);
  std::vector<Measurement> best = report_predictions(split.left_out, values_of(fitted), "");
  // The spirals exchanged, and other straights.
  const BlimpSplit other = split_blimp(flights, {120, 124, 130, 136});
  for (Measurement& m :
       report_predictions(other.left_out, values_of(fit_blimp(other.training)), "_other_split"))
    best.push_back(std::move(m));
  Measurement nearest = *std::ranges::min_element(best, {}, [](const Measurement& m) { return *m.ratio; });
  nearest.metric = "best_baseline";
  print(nearest);
  if (!options.quick) {
    const FitResult with_added_mass = fit_blimp(split.training, AddedMass::diagonal);
    report_predictions(split.left_out, values_of(with_added_mass), "_added_mass");
    const FitResult other_with = fit_blimp(other.training, AddedMass::diagonal);
    report_predictions(other.left_out, values_of(other_with), "_added_mass_other_split");
    for (const char* name : {"M_x", "M_y", "M_z", "J_x", "J_y", "J_z"}) {
      report(name, value_of(with_added_mass, name));
      report(fmt::format("{}_stderr", name), error_of(with_added_mass, name));
    }
  }
  constexpr int kSplits = 20;
  Claims claims = claims_of_halves(flights, options.quick ? 2 : kSplits);
  claims.add(fitted);
  report("converged_fraction", claims.converged_fraction());
  report("halves_beyond_two_errors", claims.halves_beyond_two_errors());
  Coefficients errors;
  if (!options.quick) errors = jackknife_errors(split.training);
  for (const std::string& name : blimp_coefficients()) {
    report(name, value_of(fitted, name));
    report(name + "_stderr", error_of(fitted, name));
    if (!options.quick) report(name + "_stderr_left_out", errors.at(name));
  }
}

}  // namespace samara::benchmarks::identification
