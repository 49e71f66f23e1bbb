/// The reference plate, fluttering and tumbling: coefficients and initial state from one noisy capture.
#include <algorithm>
#include <cmath>

#include "cases.h"
#include "plate.h"
#include "real_data.h"
#include "samara/identification/fit/fit.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"

namespace samara::benchmarks::identification {

namespace {

using samara::identification::Coefficient;
using samara::identification::FitOptions;
using samara::identification::FitResult;

/// A coefficient is identified if its standard error is less than this share of it.
constexpr double kIdentified = 0.05;
/// Starts of coefficients, relative to the truth.
constexpr double kStartSpread = 0.35;

FitResult fit_one(double inertia_ratio, std::uint64_t seed) {
  pgd::Random random(seed);
  const auto seen = plate_capture(inertia_ratio, random);
  FitOptions options = plate_options();
  for (const Truth& c : plate_coefficients()) {
    options.starts.initial[c.name] = c.value * (1.0 + kStartSpread * (2.0 * random.uniform() - 1.0));
  }
  const auto family = samara::models::step_trajectories(models::find_model("falling_plate_nd"),
                                                        plate_fixed(inertia_ratio), plate_box(), 0.01);
  return samara::identification::fit(*family, std::vector{seen}, options);
}

/// By the fit's own account.
bool is_identified(const Coefficient& c) {
  return c.naive_standard_error && *c.naive_standard_error < kIdentified * std::abs(c.value);
}

/// Of an identified coefficient: three times the standard error up to which it counts as one.
constexpr double kNear = 0.15;

void run(const std::string& test_case, double inertia_ratio, int seeds) {
  int converged = 0;
  int identified = 0;
  int covered = 0;
  std::vector<double> errors, times;
  for (int seed = 1; seed <= seeds; ++seed) {
    const FitResult result = fit_one(inertia_ratio, static_cast<std::uint64_t>(seed));
    times.push_back(result.seconds);
    bool near = result.status == Termination::converged;
    for (std::size_t k = 0; k < result.coefficients.size(); ++k) {
      const Coefficient& c = result.coefficients[k];
      const auto truth = std::ranges::find(plate_coefficients(), c.name, &Truth::name);
      const double error = std::abs(c.value - truth->value);
      const double sigma = c.naive_standard_error.value_or(std::nan(""));
      near = near && error < 6.0 * sigma && (!is_identified(c) || error < kNear * truth->value);
      if (!is_identified(c)) continue;
      ++identified;
      errors.push_back(error / truth->value);
      covered += error < 1.96 * sigma ? 1 : 0;
    }
    converged += near ? 1 : 0;
  }
  print({kBench, test_case, "converged_fraction", static_cast<double>(converged) / seeds});
  print({kBench, test_case, "median_error", median_of(errors)});
  print({kBench, test_case, "coverage95", static_cast<double>(covered) / std::max(1, identified)});
  print({kBench, test_case, "identified_fraction",
         static_cast<double>(identified) / (seeds * static_cast<double>(plate_coefficients().size()))});
  print({kBench, test_case, "time", median_of(times), "s"});
}

}  // namespace

void plate_cases(const Options& options) {
  const int seeds = options.quick ? 20 : 200;
  if (options.wants("plate_flutter")) run("plate_flutter", 1.1, seeds);
  if (options.wants("plate_tumbling")) run("plate_tumbling", 1.4, seeds);
}

}  // namespace samara::benchmarks::identification
