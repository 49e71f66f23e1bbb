/// Square plates in water, from positions alone: coefficients that meet windows and long falls in one cost.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cases.h"
#include "real_data.h"
#include "samara/identification/fit.h"
#include "settling_plates.h"

namespace samara::benchmarks::identification {

namespace {

using samara::identification::Baseline;
using samara::identification::Capture;
using samara::identification::FitOptions;
using samara::identification::FitResult;
using samara::identification::Flutter;

constexpr const char* kCase = "settling_plates";
constexpr int kSweeps = 25;
constexpr int kRepeats = 8;  ///< of the bootstrap

void say(const char* what, const Flutter& f) {
  fmt::print(stderr, "  {}: {:.2f} cm/s, {:.2f} Hz, {:.2f} cm\n", what, 100.0 * f.fall_speed, f.frequency,
             100.0 * f.amplitude);
}

struct Score {
  double fit_median = 0.0, next_median = 0.0, next_median_line = 0.0;
  double speed_error = 0.0, frequency_error = 0.0, amplitude_error = 0.0;
};

Score one_material(const std::filesystem::path& folder, const std::string& material, std::size_t most_drops,
                   int repeats) {
  const PlateKind& kind = plate_kind(material);
  const std::vector<Capture> drops = plate_drops(folder, kind);
  std::vector<Capture> fitted;
  std::vector<Capture> others;
  for (std::size_t k = 0; k < drops.size(); ++k) (k % 2 == 0 ? fitted : others).push_back(drops[k]);
  const Flutter measured = measured_flutter(fitted, kind);
  const Flutter unseen_flutter = measured_flutter(others, kind);

  const auto windows_of = [&](const std::vector<Capture>& all) {
    std::vector<Window> windows;
    for (std::size_t k = 0; k < std::min(most_drops, all.size()); ++k) {
      // Spread over the positions of release.
      const Capture& drop = all[k * all.size() / std::min(most_drops, all.size())];
      for (Window& window : cut(drop, kind.frames, kind.ahead)) windows.push_back(std::move(window));
    }
    return windows;
  };
  const std::vector<Window> seen = windows_of(fitted);
  const std::vector<Window> unseen = windows_of(others);
  const auto family = plate_family(kind);
  const FitOptions options = settling_options();
  const FitResult of_windows = samara::identification::fit(*family, captures_of(seen), options);
  fmt::print(stderr, "{} {}: {} drops, {} windows in {:.1f} s, {} iterations; {}\n", kCase, material,
             drops.size(), seen.size(), of_windows.seconds, of_windows.iterations, of_windows.message);
  std::map<std::string, double> scatter;
  if (repeats > 0) scatter = bootstrap_errors(*family, options, of_windows, seen, "drop", repeats);
  for (const auto& c : of_windows.coefficients) {
    fmt::print(stderr, "  {} {:.3g} +- {:.2g}", c.name, c.value, c.standard_error.value_or(-1.0));
    if (scatter.contains(c.name)) fmt::print(stderr, ", bootstrap {:.2g}", c.value * scatter.at(c.name));
    fmt::print(stderr, "\n");
  }
  const JointFit joint = fit_jointly(kind, of_windows, measured, kSweeps);
  say("measured, fitted drops", measured);
  say("measured, others", unseen_flutter);
  Coefficients of_windows_alone;
  for (const auto& c : of_windows.coefficients) of_windows_alone[c.name] = c.value;
  if (const auto alone = simulated_flutter(kind, of_windows_alone)) say("windows alone", *alone);
  say("windows and statistics", joint.simulated);
  fmt::print(stderr, "  cost of windows {:.3g}, of statistics {:.3g}\n", joint.cost.windows,
             joint.cost.statistics);

  FitOptions held = options;
  held.rounds = 1;
  for (const auto& [name, value] : joint.coefficients) {
    held.fixed[name] = value;
    fmt::print(stderr, "  {} {:.4g}\n", name, value);
  }
  held.log_scale.clear();
  held.priors.clear();
  held.initial.clear();
  const FitResult states = samara::identification::fit(*family, captures_of(unseen), held);
  const std::vector<double> next = model_errors(*family, held, states, unseen);
  const FitOptions held_windows = with_coefficients(held, of_windows);
  const FitResult states_windows = samara::identification::fit(*family, captures_of(unseen), held_windows);
  fmt::print(stderr, "  next: joint {:.2f} mm, windows alone {:.2f} mm\n", 1e3 * median_of(next),
             1e3 * median_of(model_errors(*family, held_windows, states_windows, unseen)));
  return {.fit_median = median_of(window_misfits(states)),
          .next_median = median_of(next),
          .next_median_line = median_of(baseline_errors(Baseline::straight_line, unseen)),
          .speed_error = std::abs(joint.simulated.fall_speed / unseen_flutter.fall_speed - 1.0),
          .frequency_error = std::abs(joint.simulated.frequency / unseen_flutter.frequency - 1.0),
          .amplitude_error = std::abs(joint.simulated.amplitude / unseen_flutter.amplitude - 1.0)};
}

}  // namespace

void settling_plates_case(const Options& options) {
  if (!options.wants(kCase)) return;
  const auto folder = measured_set(kCase, "settling-plates-water-cardiff");
  if (!folder) return;
  Score worst;
  for (const char* material : {"POM", "PTFE"}) {
    const Score score = one_material(*folder, material, options.quick ? 5 : 10, options.quick ? 0 : kRepeats);
    for (double Score::*part : {&Score::fit_median, &Score::next_median, &Score::next_median_line,
                                &Score::speed_error, &Score::frequency_error, &Score::amplitude_error}) {
      worst.*part = std::max(worst.*part, score.*part);
    }
    fmt::print(stderr, "  fit {:.2f} mm, next {:.2f} mm, straight line {:.2f} mm\n", 1e3 * score.fit_median,
               1e3 * score.next_median, 1e3 * score.next_median_line);
  }
  print({kBench, kCase, "fit_median", worst.fit_median, "m"});
  print({kBench, kCase, "next_median", worst.next_median, "m"});
  print({kBench, kCase, "next_median_line", worst.next_median_line, "m"});
  print({kBench, kCase, "speed_error", worst.speed_error});
  print({kBench, kCase, "frequency_error", worst.frequency_error});
  print({kBench, kCase, "amplitude_error", worst.amplitude_error});
}

}  // namespace samara::benchmarks::identification
