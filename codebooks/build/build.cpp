#include "samara/codebooks/build/build.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/provenance.h"
#include "samara/codebooks/build/compaction.h"
#include "samara/codebooks/build/described.h"
#include "samara/codebooks/build/effort.h"
#include "samara/codebooks/build/field_builder.h"
#include "samara/codebooks/build/pgd_builder.h"
#include "samara/codebooks/build/sampling_builder.h"
#include "samara/codebooks/build/stepped_builder.h"
#include "samara/codebooks/certify/builder_end.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/certify/measure.h"
#include "samara/codebooks/fields/ready_field.h"
#include "samara/codebooks/plan/make_plan.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/models/checks/parameter_warnings.h"

namespace samara::codebooks {

namespace {

// What the trials of a plan of kind "auto" may use: both take about as long.
constexpr long kTrialTrajectories = 20'000;
constexpr long kTrialEvaluations = 50'000;
/// Trajectories by steps, microseconds each, that a build may take where the plan sets no limit.
constexpr long kMostSteppedTrajectories = 20'000'000;
/// Of so many coordinates or fewer, the few trajectories that sampling takes cost less than the lines and checks
/// alone that stepping needs.
constexpr std::size_t kFewCoordinates = 2;

using Clock = std::chrono::steady_clock;

std::string sentence(const BuildRecord& record, const Certificate& certificate, bool of_command,
                     bool cancelled) {
  if (cancelled) {
    return fmt::format("the build was cancelled; its certificate covers {} of {} points",
                       certificate.points - certificate.failed_points, certificate.points);
  }
  if (certificate.met) {
    return fmt::format("certified: {}largest error {:.3g} <= {:.3g} at {} points",
                       certificate.points < kCertificatePoints ? verdict(record, certificate) + ", " : "",
                       certificate.max_error, certificate.tolerance, certificate.points);
  }
  if (certificate.failed_points > 0) {
    return fmt::format("the certificate is incomplete: {} of {} {}{}{}", certificate.failed_points,
                       certificate.points, of_command ? "points have no answer" : "integrations failed",
                       certificate.failure.empty() ? "" : ", the first with: ", certificate.failure);
  }
  if (!certificate.failure.empty())
    return fmt::format("the certificate is incomplete, a climb failed with: {}", certificate.failure);
  const std::string error = fmt::format("largest error {:.3g} at {} points, tolerance {:.3g}",
                                        certificate.max_error, certificate.points, certificate.tolerance);
  if (record.status != Termination::converged)
    return fmt::format("the build {}: {}; {}",
                       is_only_unfinished(record, certificate) ? "did not converge" : "missed its tolerance",
                       record.message, error);
  return fmt::format("the build missed its tolerance: {}", error);
}

/// `limit` or the plan's own, whichever is less.
long at_most(const Plan& plan, long limit) {
  return plan.builder.max_calls > 0 ? std::min(plan.builder.max_calls, limit) : limit;
}

Solution chosen(Solution solution, const std::string& reason) {
  solution.record.message += fmt::format("; chosen because {}", reason);
  return solution;
}

CertifyOptions certify_options(const Plan& plan, const ProgressCallback& progress) {
  CertifyOptions result;
  result.seed = plan.certificate_seed();
  result.tolerance = plan.relative;
  result.absolute = plan.absolute;
  result.threads = plan.builder.threads;
  result.progress = progress;
  return result;
}

/// Certifies what a build comes up with, each time on points that it has not seen.
class Certifier {
 public:
  using Measure = std::function<Measured(const Codebook&, const CertifyOptions&, Extent)>;
  /// How many points a certificate takes that comes after so many refutations.
  using Points = std::function<int(const Codebook&, int refuted_before)>;

  Certifier(CertifyOptions options, Points points, Measure measure)
      : options_(std::move(options)), points_(std::move(points)), measure_(std::move(measure)) {}

  CertifyOptions& options() { return options_; }

  Measured operator()(const Codebook& book, Extent extent) {
    options_.points = points_(book, refuted_);
    Measured measured = measure_(book, options_, extent);
    measured.certificate.refuted_before = refuted_;
    refuted_ += measured.wrong.cols() > 0 ? 1 : 0;
    ++options_.seed;
    return measured;
  }

 private:
  CertifyOptions options_;
  Points points_;
  Measure measure_;
  int refuted_ = 0;
};

/// @param calls of a command, whose duration counts; null: of a model
Certifier::Points certificate_sizes(const Plan& plan, const BuildOptions& options,
                                    const CallMemory* calls = nullptr) {
  return [&plan, given = options.certificate_points, calls](const Codebook& book, int refuted_before) {
    if (given) return *given;
    return plan.certificate_points(calls == nullptr ? 0.0 : calls->seconds_per_call(),
                                   book.build().evaluations, refuted_before);
  };
}

/// A plan on its way to a codebook.
struct Build {
  const Plan& plan;
  const BuildOptions& options;
  const ProgressCallback& progress;
  const bool& cancelled;
  ModelDescription model;
  Certifier certifier;
  /// Evaluations that the reference integrator takes for a trajectory, where the builder takes none; 0: not known.
  double per_trajectory = 0.0;
  Clock::time_point begin = Clock::now();

  Codebook book_of(Solution solution) const {
    if (per_trajectory > 0.0) solution.record.grid_size = per_trajectory * sweep_size(solution.pieces);
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    return Codebook(model, std::move(solution.pieces), std::move(solution.record),
                    made_now(plan.text, seconds), {}, plan.title);
  }

  Outcome<Solution> solve_by_sampling(CallMemory& calls, long max_calls) {
    return codebooks::solve_by_sampling(plan, calls, max_calls, progress, certify_claim());
  }

  Outcome<Solution> solve_by_steps(const models::ParametricModel& parametric) {
    KeptState kept = {.file = options.checkpoint};
    Checkpoint checkpoint(options.checkpoint, plan.whole_text());
    if (options.resume && is_checkpoint(options.checkpoint)) kept.state = checkpoint.steps();
    if (!options.checkpoint.empty()) {
      kept.save = told_once<std::vector<double>>(
          [&](const std::vector<double>& state) { checkpoint.save_steps(state); }, options.warning);
    }
    return codebooks::solve_by_steps(plan, parametric, at_most(plan, kMostSteppedTrajectories), progress,
                                     certify_claim(), kept);
  }

  /// The codebook with its certificate, a fresh one unless the solution brings its own.
  BuildResult certified(Solution solution) {
    std::optional<Certificate> certificate = std::move(solution.certificate);
    const ErrorBudget spent = solution.spent;
    const Codebook book = book_of(std::move(solution));
    if (!certificate) certificate = certifier(book, Extent::all_points).certificate;
    return finished(book, spent, std::move(*certificate));
  }

 private:
  CertifyClaim certify_claim() {
    return [this](const Piece& piece, double calls_made) {
      BuildRecord record;
      record.evaluations = calls_made;
      return certifier(book_of({{piece}, std::move(record), {}}), Extent::until_wrong);
    };
  }

  BuildResult finished(const Codebook& book, const ErrorBudget& spent, Certificate certificate) const {
    const BuildRecord& record = book.build();
    certificate.met = certificate.met && is_left_to_certificate(record, spent, certificate.tolerance);
    certificate.spent = spent;
    if (record.status == Termination::failed) certificate.failure = record.message;
    const bool met = certificate.met;
    const bool of_command = book.is_of_command();
    std::string message = sentence(record, certificate, of_command, cancelled);
    const bool has_failed = of_command && (record.status == Termination::failed ||
                                           certificate.failed_points > 0 || !certificate.failure.empty());
    return {book.with_certificate(std::move(certificate)), met, std::move(message), cancelled || has_failed};
  }
};

/// Sampling without a field has nothing to store, whatever ended it.
/// @throws NoResultError
Solution given(Outcome<Solution> sampled) {
  if (sampled) return std::move(*sampled);
  throw NoResultError(fmt::format("the build ended before it had a result: {}", sampled.ending().message));
}

/// Nothing where the engine has no result or refuses the plan: what sampling found must not be lost for it.
std::optional<Solution> engine_trial(const Build& build, const models::ParametricModel& model) {
  try {
    return solve_by_pgd(build.plan, model, build.options, at_most(build.plan, kTrialEvaluations),
                        build.progress);
  } catch (const NoResultError&) {
    return std::nullopt;
  } catch (const ArgumentError&) {
    return std::nullopt;
  }
}

/// Kind "auto" of more than a few coordinates: trajectories by steps. A field that they leave short of the tolerance
/// is kept where the engine's trial does no better.
/// @returns nothing where steps give no field: the choice is open
std::optional<Solution> solve_by_steps_first(Build& build, const models::ParametricModel& model) {
  if (build.plan.box.size() <= kFewCoordinates) return std::nullopt;
  Outcome<Solution> stepped = build.solve_by_steps(model);
  if (!stepped) return std::nullopt;
  if (stepped->record.status == Termination::converged)
    return chosen(std::move(*stepped), "trajectories by steps met the tolerance");
  if (build.cancelled) return std::move(*stepped);
  std::optional<Solution> second = engine_trial(build, model);
  const std::string missed = fmt::format("steps did not ({})", to_string(stepped->record.status));
  if (second && second->record.status == Termination::converged) return chosen(std::move(*second), missed);
  return chosen(std::move(*stepped), "the trial of the engine did not converge either");
}

/// Kind "auto": steps; then sampling, whose cost is known before it is spent, has the first trial, the PGD engine
/// the second. All are counted, not timed, so that the choice is the same everywhere.
Solution solve_by_trial(Build& build, const models::ParametricModel& model) {
  const Plan& plan = build.plan;
  if (plan.prescribes_axes() || plan.builder.strategy != "auto") {
    return chosen(solve_by_pgd(plan, model, build.options, plan.builder.max_calls, build.progress),
                  plan.prescribes_axes() ? "the plan prescribes an axis, and sampling chooses its own"
                                         : "the plan names a strategy of the engine");
  }
  if (std::optional<Solution> stepped = solve_by_steps_first(build, model)) return std::move(*stepped);
  CallMemory calls = calls_of(plan, model_source(plan, model), build.options);
  Outcome<Solution> first = build.solve_by_sampling(calls, at_most(plan, kTrialTrajectories));
  const Termination status = first ? first->record.status : first.ending().status;
  if (status == Termination::converged)
    return chosen(std::move(*first),
                  fmt::format("it needed no more than the {} trajectories of its trial", kTrialTrajectories));
  // Where there is no trajectory, no builder finds a solution.
  if (build.cancelled || status == Termination::failed || status == Termination::not_finite)
    return given(std::move(first));
  std::optional<Solution> second = engine_trial(build, model);
  const std::string failed = fmt::format("sampling did not converge ({})", to_string(status));
  if (second && second->record.status == Termination::converged) return chosen(std::move(*second), failed);
  const std::string neither = "neither builder converged in its trial, and the calls of sampling are bounded";
  if (build.cancelled || status != Termination::max_calls) return chosen(given(std::move(first)), neither);
  return chosen(given(build.solve_by_sampling(calls, at_most(plan, kMostSampledCalls))), neither);
}

Solution solve(Build& build, const models::ParametricModel& model) {
  const Plan& plan = build.plan;
  if (plan.builder.kind == "pgd")
    return solve_by_pgd(plan, model, build.options, plan.builder.max_calls, build.progress);
  if (plan.builder.kind == "auto") return solve_by_trial(build, model);
  if (plan.builder.strategy == "steps") return given(build.solve_by_steps(model));
  CallMemory calls = calls_of(plan, model_source(plan, model), build.options);
  return given(build.solve_by_sampling(calls, at_most(plan, kMostSampledCalls)));
}

/// What is fixed, and the centre of the box.
void warn_of_parameters(const Plan& plan, const models::Model& model, const BuildOptions& options) {
  if (!options.warning) return;
  std::map<std::string, double> values = plan.fixed;
  for (const BoxEntry& entry : plan.box) values.emplace(entry.name, 0.5 * (entry.lower + entry.upper));
  for (const std::string& sentence : models::parameter_warnings(model, values)) options.warning(sentence);
}

BuildResult build_of_model(const Plan& plan, const BuildOptions& options, const ProgressCallback& progress,
                           const bool& cancelled) {
  const models::ParametricModel model = plan.parametric_model();
  warn_of_parameters(plan, model.model(), options);
  Build build{plan,
              options,
              progress,
              cancelled,
              describe(model),
              {certify_options(plan, progress), certificate_sizes(plan, options),
               [&](const Codebook& book, const CertifyOptions& certify_by, Extent extent) {
                 return measure(book, model, certify_by, extent);
               }}};
  Solution solved = solve(build, model);
  if (solved.record.builder == "pgd") build.per_trajectory = evaluations_per_trajectory(plan, model);
  // Fewer numbers must not cost the certificate.
  for (const double share : {0.9, 0.4}) {
    std::optional<Solution> compact = compacted(solved, compaction_of(plan, share));
    if (!compact) break;
    BuildResult result = build.certified(std::move(*compact));
    if (result.met || cancelled) return result;
  }
  return build.certified(std::move(solved));
}

/// A command that has failed is not called again for the certificate.
BuildResult build_of_command(const Plan& plan, const pgd::PointsFunction& function,
                             const BuildOptions& options, const ProgressCallback& progress,
                             const bool& cancelled) {
  CallMemory calls = calls_of(plan, command_source(plan, function), options);
  Build build{plan,
              options,
              progress,
              cancelled,
              describe(plan),
              {certify_options(plan, progress), certificate_sizes(plan, options, &calls),
               [&](const Codebook& book, const CertifyOptions& certify_by, Extent extent) {
                 return measure(book, calls, certify_by, extent);
               }}};
  Solution solved = given(build.solve_by_sampling(calls, at_most(plan, kMostSampledCalls)));
  if (solved.record.status == Termination::failed)
    build.certifier.options().progress = [](const Progress&) { return false; };
  BuildResult result = build.certified(std::move(solved));
  calls.save();
  try {
    calls.finish();
  } catch (const NoResultError&) {
    std::error_code ignored;
    std::filesystem::remove(options.checkpoint, ignored);
    throw;
  }
  return result;
}

/// A field is made finer until its certificate holds.
BuildResult build_of_field(const Plan& plan, const BuildOptions& options, const ProgressCallback& progress,
                           const bool& cancelled) {
  if (options.resume && is_checkpoint(options.checkpoint))
    throw bad_checkpoint(options.checkpoint, "it is of another plan: builds of fields keep none");
  std::vector<std::string> free;
  for (const BoxEntry& entry : plan.box) free.push_back(entry.name);
  const FieldReference reference = exact_reference(*plan.field, plan.fixed, free);
  Build build{plan,
              options,
              progress,
              cancelled,
              describe_field(plan),
              {certify_options(plan, progress), certificate_sizes(plan, options),
               [&](const Codebook& book, const CertifyOptions& certify_by, Extent extent) {
                 return measure(book, reference, certify_by, extent);
               }}};
  double aim = first_aim(plan);
  for (int attempt = 1;; ++attempt) {
    BuildResult result = build.certified(solve_field(plan, aim, attempt, progress));
    // Where terms do not suffice, more of them would be needed for less.
    const bool is_at_limit = result.book.build().status == Termination::rank_limit;
    if (result.met || cancelled || is_at_limit || attempt == kFieldAttempts) return result;
    aim = next_aim(aim, result.book.certificate()->max_error, plan);
  }
}

/// @param function instead of the command of the plan; empty: none
BuildResult built(const Plan& plan, const pgd::PointsFunction& function, const BuildOptions& options) {
  check_checkpoint_path(options.checkpoint);
  // Once cancelled, always cancelled: neither solver nor certificate ask again.
  bool cancelled = false;
  ProgressCallback progress;
  if (options.progress) {
    progress = [&](const Progress& report) { return !(cancelled = cancelled || !options.progress(report)); };
  }
  // Everything that is shared between threads below is shared between those of the plan.
  const int cores = tbb::info::default_concurrency();
  tbb::task_arena arena(plan.builder.threads > 0 ? std::min(plan.builder.threads, cores) : cores);
  BuildResult result = arena.execute([&] {
    return plan.command            ? build_of_command(plan, function, options, progress, cancelled)
           : plan.field != nullptr ? build_of_field(plan, options, progress, cancelled)
                                   : build_of_model(plan, options, progress, cancelled);
  });
  if (!options.checkpoint.empty() && !options.keep_checkpoint && !result.resumable) {
    std::error_code ignored;
    std::filesystem::remove(options.checkpoint, ignored);
  }
  return result;
}

}  // namespace

BuildResult build(const models::ParametricModel& model, const BuildRequest& request,
                  const BuildOptions& options) {
  return build(make_plan(model, request), options);
}

BuildResult build(const Plan& plan, const BuildOptions& options) {
  return built(plan, {}, options);
}

BuildResult build(const Plan& plan, const pgd::PointsFunction& function, const BuildOptions& options) {
  if (!plan.command)
    throw ArgumentError(
        fmt::format("the plan {} has no command for which a function could answer", plan.source));
  if (!function) throw ArgumentError("a build from no function: an empty one was given");
  return built(plan, function, options);
}

}  // namespace samara::codebooks
