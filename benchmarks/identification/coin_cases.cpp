/// Whole fits of the measured coin from its codebook, beside CVODES at the codebook's accuracy; a thousand fits
/// with random weights; and what residuals cost with a delay of the captures' clocks, beside those without.
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "cases.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/problem/fit_config.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/starts/start_point.h"
#include "samara/models/trajectories/step_trajectories.h"

namespace samara::benchmarks::identification {

namespace {

namespace id = samara::identification;

const std::filesystem::path kExample = std::filesystem::path(SAMARA_EXAMPLES_DIR) / "coin";
/// Of CVODES: the loosest that comes near the accuracy of the codebook. First_walk looks for the one that reaches it,
/// with which fits take CVODES longer.
constexpr double kTolerance = 1e-5;

/// Residuals of all tracks with their derivatives, at the first start.
class AllResiduals {
 public:
  AllResiduals(const models::TrajectoryFamily& family, const std::vector<id::Capture>& captures,
               const id::FitOptions& options)
      : problem_(id::make_problem(family.info(), captures, options)),
        residuals_(id::make_residuals(family, problem_)),
        point_(id::start_point(problem_, residuals_, 0)) {}

  void operator()() {
    for (std::size_t k = 0; k < residuals_.size(); ++k)
      residuals_[k].evaluate(point_.shared.data(), point_.own[k].data(), nullptr, true);
  }

 private:
  id::FitProblem problem_;
  std::vector<id::SegmentResidual> residuals_;
  id::FitPoint point_;
};

/// The factor in time that a delay of up to six frames makes, for trajectories of any source.
void delay_case(const codebooks::Codebook& book, const std::vector<id::Capture>& captures,
                id::FitOptions asked) {
  asked.compared.span = 0.35;
  id::FitOptions delayed = asked;
  delayed.measurement.delay = models::Interval{0.0, 0.1};
  const auto compare = [&](const std::string& source, const models::TrajectoryFamily& family) {
    AllResiduals without(family, captures, asked), with(family, captures, delayed);
    const Pair times = time_both(std::ref(with), std::ref(without));
    print({kBench, "coin_delay", source + "_factor", times.ours / times.theirs});
  };
  const auto family = codebooks::codebook_trajectories(book);
  compare("codebook", *family);
  compare("cvodes", *codebooks::reference_trajectories(book, {.relative_tolerance = kTolerance}));
  const models::ParametricModel& equations = *family->equations();
  std::map<std::string, models::Interval> box;
  for (const models::FamilyCoordinate& c : family->info().coordinates) box[c.name] = {c.lower, c.upper};
  compare("steps", *models::step_trajectories(equations.shared_model(), equations.fixed(), box, 2e-3));
}

}  // namespace

void coin_cases(const Options& options) {
  if (!options.wants("coin_fit") && !options.wants("bootstrap_1000") && !options.wants("coin_delay")) return;
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
  if (options.wants("coin_delay")) delay_case(book, captures, asked);
  if (options.wants("bootstrap_1000")) {
    asked.uncertainty.bootstrap.replicates = 1000;
    id::FitResult result;
    const double time = time_of([&] { result = id::fit(*family, captures, asked); }, 3, 0.0);
    print({kBench, "bootstrap_1000", "time", time, "s"});
    print({kBench, "bootstrap_1000", "standard_error", result.bootstrap->standard_errors.front()});
  }
}

}  // namespace samara::benchmarks::identification
