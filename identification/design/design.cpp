#include "samara/identification/design/design.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/identification/design/capture_evaluator.h"
#include "samara/identification/design/experiment.h"
#include "samara/identification/design/film_worth.h"
#include "samara/identification/design/precision.h"
#include "samara/identification/design/release_search.h"
#include "samara/identification/problem/known_so_far.h"

namespace samara::identification {

namespace {

using Clock = std::chrono::steady_clock;

/// Everything that does not depend on releases.
struct DesignProblem {
  KnownSoFar known;
  Experiment experiment;
  Precision precision;
  CaptureEvaluator evaluator;

  DesignProblem(const models::TrajectoryFamily& family, const FitResult& fitted, const DesignOptions& options)
      : known(known_so_far(fitted)),
        experiment(make_experiment(family, fitted, known, options)),
        precision(known, options),
        evaluator(family, experiment, known, known.draws(options.draws, options.seed)) {
    // What each frame says is kept: a kilobyte or two, by capture and draw.
    constexpr double kMostKept = 500000;
    const double frames = static_cast<double>(options.captures) * options.draws * experiment.frames;
    if (frames > kMostKept) {
      throw ArgumentError(
          fmt::format("{} captures of {} frames for {} draws are {:g} frames; at most {:g} were expected",
                      options.captures, experiment.frames, options.draws, frames, kMostKept));
    }
    if (options.times > experiment.frames) {
      throw ArgumentError(fmt::format("times is {}; at most the {} frames of a capture were expected",
                                      options.times, experiment.frames));
    }
  }
};

void add_warnings(const FitResult& fitted, const DesignProblem& problem, Design& design) {
  if (!fitted.is_usable())
    design.warnings.add(WarningKind::source, fmt::format("the fit so far: {}", fitted.message));
  const bool is_white = !fitted.whiteness || !fitted.whiteness->p_value || *fitted.whiteness->p_value >= 0.05;
  if (!is_white && !problem.known.is_clustered) {
    design.warnings.add(
        WarningKind::errors,
        "residuals are not independent from frame to frame, and there are no two clusters of captures to "
        "tell what that costs: errors now and expected are too small");
  }
  for (std::size_t k = 0; k < design.captures.size(); ++k) {
    if (design.captures[k].followed == 1.0) continue;
    design.warnings.add(
        WarningKind::source,
        fmt::format("capture {} has a trajectory to the end of the film for {:.0f} % of the draws of the "
                    "coefficients only",
                    k + 1, 100.0 * design.captures[k].followed));
  }
}

Design design_of(const FitResult& fitted, DesignProblem& problem, const std::vector<Release>& releases,
                 const DesignOptions& options) {
  const KnownSoFar& known = problem.known;
  const RowsOfCaptures rows = problem.evaluator.rows(releases);
  const Informations all = with_captures(problem.precision, rows, [](int, int) { return true; });
  Design design{.model = fitted.model,
                .criterion = options.criterion,
                .of = options.coefficients.empty() ? known.names : options.coefficients,
                .duration = problem.experiment.duration,
                .frames = problem.experiment.frames,
                .errors_are_clustered = known.is_clustered,
                .inflation = known.inflation,
                .draws = options.draws,
                .coordinates = problem.experiment.coordinates};
  const Eigen::VectorXd errors = problem.precision.errors(all);
  for (std::size_t k = 0; k < fitted.coefficients.size(); ++k) {
    const Coefficient& c = fitted.coefficients[k];
    const double now = known.errors[static_cast<Eigen::Index>(k)];
    design.coefficients.push_back({.name = c.name,
                                   .unit = c.unit,
                                   .value = c.value,
                                   .now = now,
                                   .was_determined = known.determined[k] != 0,
                                   .expected = now * errors[static_cast<Eigen::Index>(k)]});
  }
  for (std::size_t k = 0; k < releases.size(); ++k) {
    const auto there =
        std::ranges::count_if(rows[k], [](const CaptureRows& draw) { return draw.unknowns() > 0; });
    design.captures.push_back({releases[k], static_cast<double>(there) / options.draws});
  }
  const bool any =
      std::ranges::any_of(design.captures, [](const ProposedCapture& c) { return c.followed > 0.0; });
  if (!any) throw NoResultError("none of the releases has a trajectory to the end of the film");
  design.error = problem.precision.error(all);
  design.random_error = std::nan("");
  add_film_worth(rows, problem.experiment, problem.precision, options, design);
  add_warnings(fitted, problem, design);
  return design;
}

void finish(const models::TrajectoryFamily& family, const DesignProblem& problem, Clock::time_point begin,
            Design& design) {
  design.source = family.info().source;
  design.evaluations = problem.evaluator.evaluations();
  design.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
}

void check_releases(const Experiment& experiment, std::span<const std::vector<double>> releases) {
  if (releases.empty()) throw ArgumentError("there are no releases; at least one was expected");
  for (const std::vector<double>& release : releases) {
    if (release.size() != experiment.coordinates.size()) {
      throw ArgumentError(fmt::format("a release has {} values; one for each of {} coordinates was expected",
                                      release.size(), experiment.coordinates.size()));
    }
    for (std::size_t k = 0; k < release.size(); ++k) {
      const models::Interval& box = experiment.options.unknowns.box.at(experiment.coordinates[k].name);
      if (release[k] >= box.lower && release[k] <= box.upper) continue;
      throw ArgumentError(
          fmt::format("a release has \"{}\" at {}; a value in its box, {} to {}, was expected",
                      experiment.coordinates[k].name, release[k], box.lower, box.upper));
    }
  }
}

}  // namespace

std::string to_string(DesignCriterion criterion) {
  return criterion == DesignCriterion::determinant ? "D" : "A";
}

DesignCriterion design_criterion_from_string(const std::string& name) {
  for (const DesignCriterion criterion : {DesignCriterion::determinant, DesignCriterion::trace}) {
    if (to_string(criterion) == name) return criterion;
  }
  throw ArgumentError(fmt::format("criterion is \"{}\"; D or A was expected", name));
}

void validate(const DesignOptions& options) {
  constexpr int kMostCaptures = 100, kMostDraws = 1000;
  require(options.captures >= 1 && options.captures <= kMostCaptures, "captures", options.captures,
          "1 to 100");
  require(options.draws >= 1 && options.draws <= kMostDraws, "draws", options.draws, "1 to 1000");
  require(options.times >= 0, "times", options.times, "0 or more");
  if (options.duration) require_positive(*options.duration, "duration [s]");
  if (options.frames) require(*options.frames >= 2, "frames", *options.frames, "at least 2");
  for (const auto& [name, noise] : options.noise)
    require_positive(noise, fmt::format("noise of \"{}\"", name));
  for (const auto& [name, box] : options.box) {
    if (std::isfinite(box.lower) && std::isfinite(box.upper) && box.lower <= box.upper) continue;
    throw ArgumentError(
        fmt::format("the release \"{}\" is to lie from {} to {}; finite numbers, the smaller one first, "
                    "were expected",
                    name, box.lower, box.upper));
  }
}

Design design_experiment(const models::TrajectoryFamily& family, const FitResult& fitted,
                         const DesignOptions& options) {
  const auto begin = Clock::now();
  validate(options);
  DesignProblem problem(family, fitted, options);
  const FoundReleases found =
      search_releases(problem.evaluator, problem.experiment, problem.precision, options);
  Design design = design_of(fitted, problem, found.releases, options);
  design.random_error = found.random_error;
  finish(family, problem, begin, design);
  return design;
}

Design assess_releases(const models::TrajectoryFamily& family, const FitResult& fitted,
                       std::span<const std::vector<double>> releases, const DesignOptions& options) {
  const auto begin = Clock::now();
  validate(options);
  DesignProblem problem(family, fitted, options);
  check_releases(problem.experiment, releases);
  Design design = design_of(fitted, problem, {releases.begin(), releases.end()}, options);
  finish(family, problem, begin, design);
  return design;
}

}  // namespace samara::identification
