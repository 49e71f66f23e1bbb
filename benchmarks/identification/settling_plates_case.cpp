/// Square plates in water, from positions alone: coefficients that meet windows and long falls in one cost.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cases.h"
#include "real_data.h"
#include "samara/identification/fit/fit.h"
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
constexpr int kReplicates = 20;  ///< of the bootstrap: they tell an error to 16 %

void say(const char* what, const Flutter& f) {
  fmt::print(stderr, "  {}: {:.2f} cm/s, {:.2f} Hz, {:.2f} cm\n", what, 100.0 * f.fall_speed, f.frequency,
             100.0 * f.amplitude);
}

struct Score {
  double fit_median = 0.0, next_median = 0.0, next_median_line = 0.0;
  BestBaseline baseline = {};
  double speed_error = 0.0, frequency_error = 0.0, amplitude_error = 0.0;
};

/// Drops to fit, and others.
struct Halves {
  std::vector<Capture> fitted, others;
};
Halves alternately(const std::vector<Capture>& drops) {
  Halves halves;
  for (std::size_t k = 0; k < drops.size(); ++k) {
    (k % 2 == 0 ? halves.fitted : halves.others).push_back(drops[k]);
  }
  return halves;
}

/// Of so many drops at most, spread over the positions of release.
std::vector<Window> windows_of(const std::vector<Capture>& drops, const PlateKind& kind, std::size_t most) {
  std::vector<Window> windows;
  const std::size_t count = std::min(most, drops.size());
  for (std::size_t k = 0; k < count; ++k) {
    for (Window& window : cut(drops[k * drops.size() / count], kind.frames, kind.ahead))
      windows.push_back(std::move(window));
  }
  return windows;
}

struct Effort {
  std::size_t drops = 10;
  int replicates = 0;  ///< of the bootstrap
};

Score one_material(const std::filesystem::path& folder, const std::string& material, const Effort& effort,
                   Claims& claims) {
  const PlateKind& kind = plate_kind(material);
  const Halves drops = alternately(plate_drops(folder, kind));
  const Flutter measured = measured_flutter(drops.fitted, kind);
  const Flutter measured_others = measured_flutter(drops.others, kind);
  const std::vector<Window> seen = windows_of(drops.fitted, kind, effort.drops);
  const std::vector<Window> unseen = windows_of(drops.others, kind, effort.drops);

  const auto family = plate_family(kind);
  FitOptions options = settling_options();
  options.uncertainty.bootstrap.replicates = effort.replicates;
  const FitResult of_windows = samara::identification::fit(*family, captures_of(seen), options);
  fmt::print(stderr, "{} {}: {} drops to fit, {} windows in {:.1f} s, {} iterations; {}\n", kCase, material,
             drops.fitted.size(), seen.size(), of_windows.seconds, of_windows.iterations, of_windows.message);
  say_coefficients(of_windows);

  const FitResult of_others = samara::identification::fit(*family, captures_of(unseen), options);
  fmt::print(stderr, "  the other drops: {} windows in {:.1f} s, {} iterations; {}\n", unseen.size(),
             of_others.seconds, of_others.iterations, of_others.message);
  say_coefficients(of_others);
  claims.add_halves(of_windows, of_others);

  const JointFit joint = fit_jointly(kind, of_windows, measured, kSweeps);
  say("measured, fitted drops", measured);
  say("measured, others", measured_others);
  if (const auto alone = simulated_flutter(kind, values_of(of_windows))) say("windows alone", *alone);
  say("windows and statistics", joint.simulated);
  fmt::print(stderr, "  cost of windows {:.3g}, of statistics {:.3g}\n", joint.cost.windows,
             joint.cost.statistics);
  for (const auto& [name, value] : joint.coefficients) fmt::print(stderr, "  {} {:.4g}\n", name, value);

  const Prediction next = predict_unseen(*family, options, joint.coefficients, unseen);
  const Prediction next_alone = predict_unseen(*family, options, values_of(of_windows), unseen);
  const double line = median_of(baseline_errors(Baseline::straight_line, unseen));
  fmt::print(stderr, "  next: joint {:.2f} mm, windows alone {:.2f} mm, straight line {:.2f} mm\n",
             1e3 * median_of(next.errors), 1e3 * median_of(next_alone.errors), 1e3 * line);
  return {.fit_median = median_of(window_misfits(next.fit)),
          .next_median = median_of(next.errors),
          .next_median_line = line,
          .baseline = best_baseline(unseen),
          .speed_error = std::abs(joint.simulated.fall_speed / measured_others.fall_speed - 1.0),
          .frequency_error = std::abs(joint.simulated.frequency / measured_others.frequency - 1.0),
          .amplitude_error = std::abs(joint.simulated.amplitude / measured_others.amplitude - 1.0)};
}

}  // namespace

void settling_plates_case(const Options& options) {
  const auto folder = measured_set(options, kCase, "settling-plates-water-cardiff");
  if (!folder) return;
  Score worst;
  Score nearest;  // where the best baseline comes nearest to the model, or beats it
  Claims claims;
  for (const char* material : {"POM", "PTFE"}) {
    const Score score =
        one_material(*folder, material, options.quick ? Effort{5, 0} : Effort{10, kReplicates}, claims);
    if (nearest.next_median == 0.0 ||
        score.baseline.median / score.next_median < nearest.baseline.median / nearest.next_median)
      nearest = score;
    for (double Score::*part : {&Score::fit_median, &Score::next_median, &Score::next_median_line,
                                &Score::speed_error, &Score::frequency_error, &Score::amplitude_error}) {
      worst.*part = std::max(worst.*part, score.*part);
    }
  }
  print({kBench, kCase, "fit_median", worst.fit_median, "m"});
  print({kBench, kCase, "next_median", worst.next_median, "m"});
  print({kBench, kCase, "next_median_line", worst.next_median_line, "m"});
  print({kBench, kCase, "best_baseline", nearest.next_median, "m", nearest.baseline.name,
         nearest.baseline.median / nearest.next_median});
  print({kBench, kCase, "speed_error", worst.speed_error});
  print({kBench, kCase, "frequency_error", worst.frequency_error});
  print({kBench, kCase, "amplitude_error", worst.amplitude_error});
  print({kBench, kCase, "converged_fraction", claims.converged_fraction()});
  print({kBench, kCase, "halves_beyond_two_errors", claims.halves_beyond_two_errors()});
}

}  // namespace samara::benchmarks::identification
