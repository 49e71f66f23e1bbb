/// Whole fits of the measured coin from its codebook, beside CVODES at the codebook's accuracy; and a thousand fits
/// with random weights.
#include <filesystem>
#include <vector>

#include "cases.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/problem/fit_config.h"

namespace samara::benchmarks::identification {

namespace {

namespace id = samara::identification;

const std::filesystem::path kExample = std::filesystem::path(SAMARA_EXAMPLES_DIR) / "coin";
/// Of CVODES: the loosest that comes near the accuracy of the codebook. First_walk looks for the one that reaches it,
/// with which fits take CVODES longer.
constexpr double kTolerance = 1e-5;

}  // namespace

void coin_cases(const Options& options) {
  if (!options.wants("coin_fit") && !options.wants("bootstrap_1000")) return;
  const codebooks::Codebook book = codebooks::build(codebooks::read_plan(kExample / "plan.toml")).book;
  const auto captures = id::read_captures(kExample / "coin.toml");
  id::FitOptions asked = id::read_fit_config(kExample / "fit.toml", id::config_names(book));
  const auto family = codebooks::codebook_trajectories(book);
  const int repeats = options.quick ? 3 : 9;
  if (options.wants("coin_fit")) {
    const auto integrator = codebooks::reference_trajectories(book, {.relative_tolerance = kTolerance});
    const double ours = time_of([&] { id::fit(*family, captures, asked); }, repeats);
    const double theirs = time_of([&] { id::fit(*integrator, captures, asked); }, repeats, 0.0);
    print({kBench, "coin_fit", "time", ours, "s", "cvodes", theirs / ours});
  }
  if (options.wants("bootstrap_1000")) {
    asked.uncertainty.bootstrap.replicates = 1000;
    id::FitResult result;
    const double time = time_of([&] { result = id::fit(*family, captures, asked); }, 3, 0.0);
    print({kBench, "bootstrap_1000", "time", time, "s"});
    print({kBench, "bootstrap_1000", "standard_error", result.bootstrap->standard_errors.front()});
  }
}

}  // namespace samara::benchmarks::identification
