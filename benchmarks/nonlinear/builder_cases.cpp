// The reference plate to t = 4 a priori, by sampling, and by a sweep of the full grid.
#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "built.h"
#include "cases.h"
#include "problems.h"
#include "samara/models/batch/batch.h"
#include "samara/pgd/tensors/random.h"

namespace samara::benchmarks {

namespace {

constexpr double kEnd = 4.0;

/// Time of all trajectories of a grid of 14 nodes per coordinate, as many as such a field has: measured on at
/// most `kMost` random ones, and scaled up.
double sweep_time(const codebooks::Plan& plan) {
  constexpr double kMost = 200'000.0;
  const double all = std::pow(14.0, static_cast<double>(plan.box.size()));
  const auto count = static_cast<Eigen::Index>(std::min(all, kMost));
  const models::ParametricModel model = plan.parametric_model();
  Eigen::MatrixXd points(count, static_cast<Eigen::Index>(plan.box.size()));
  pgd::Random random(5);
  for (Eigen::Index j = 0; j < count; ++j) {
    for (std::size_t k = 0; k < plan.box.size(); ++k) {
      const codebooks::BoxEntry& entry = plan.box[k];
      points(j, static_cast<Eigen::Index>(k)) = entry.lower + (entry.upper - entry.lower) * random.uniform();
    }
  }
  std::vector<double> times;
  for (int i = 1; i <= 40; ++i) times.push_back(kEnd * i / 40);
  const double time =
      time_of([&] { (void)models::integrate_batch(model, points, times, {.step = 0.02}); }, 1, 0.0);
  return time * all / static_cast<double>(count);
}

}  // namespace

void run_builders(const Options& options) {
  for (const int coordinates : {3, 5, 7}) {
    const std::string name = fmt::format("builders_{}", coordinates);
    if (!options.wants(name)) continue;
    codebooks::Plan plan = plate_plan(coordinates, kEnd, 1e-3);
    const Built pgd = build_and_measure(plan, options.quick ? 500 : 2000);
    plan.builder.kind = "sampling";
    plan.builder.strategy = "auto";
    plan.builder.max_calls = 100'000;
    const Built sampling = build_and_measure(plan, options.quick ? 500 : 2000);
    print({kNonlinear, name, "time_pgd", pgd.time, "s"});
    print({kNonlinear, name, "time_sampling", sampling.time, "s", "pgd", pgd.time / sampling.time});
    const double sweep = sweep_time(plan);
    print({kNonlinear, name, "time_sweep", sweep, "s", "pgd", pgd.time / sweep});
    print({kNonlinear, name, "error_pgd", pgd.certificate_max});
    print({kNonlinear, name, "error_sampling", sampling.certificate_max, sampling.status});
  }
}

}  // namespace samara::benchmarks
