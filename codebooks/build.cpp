#include "samara/codebooks/build.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "samara/base/errors.h"
#include "samara/base/version.h"
#include "samara/codebooks/call_memory.h"
#include "samara/codebooks/certify.h"
#include "samara/codebooks/certify_calls.h"
#include "samara/codebooks/checkpoint.h"
#include "samara/codebooks/compaction.h"
#include "samara/codebooks/pgd_builder.h"
#include "samara/codebooks/sampling_builder.h"
#include "samara/models/parameter_warnings.h"

namespace samara::codebooks {

namespace {

// What the trials of a plan of kind "auto" may use: both take about as long.
constexpr long kTrialTrajectories = 20'000;
constexpr long kTrialEvaluations = 50'000;

using Clock = std::chrono::steady_clock;

ModelDescription describe(const models::ParametricModel& model) {
  const models::ModelInfo& info = model.model().info();
  ModelDescription description{info.name,     info.title, info.equations, info.frames, info.source,
                               model.fixed(), {}};
  std::map<std::string, std::string>& units = description.fixed_units;
  for (const auto& parameter : info.parameters) units[parameter.name] = parameter.unit;
  for (const auto& state : info.states) units[state.name + "(0)"] = state.unit;
  std::erase_if(units, [&](const auto& item) { return !model.fixed().contains(item.first); });
  return description;
}

/// Of a command: its call stands for the equations.
ModelDescription describe(const Plan& plan) {
  ModelDescription description;
  description.name = kCommandModel;
  description.title = "what a program answers";
  description.equations = fmt::format("{}", fmt::join(plan.command->run, " "));
  description.frames = "those of the program";
  description.source = "the plan";
  description.fixed = plan.fixed;
  for (const CommandQuantity& input : plan.command->inputs) {
    if (plan.fixed.contains(input.name)) description.fixed_units[input.name] = input.unit;
  }
  return description;
}

Provenance provenance_of(const Plan& plan, double seconds) {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return {fmt::format("samara {}", version()), plan.text,
          fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))), host.data(), seconds};
}

std::string sentence(const BuildRecord& record, const Certificate& certificate, bool of_command,
                     bool cancelled) {
  if (cancelled) {
    return fmt::format("the build was cancelled; its certificate covers {} of {} points",
                       certificate.points - certificate.failed_points, certificate.points);
  }
  if (certificate.met) {
    return fmt::format("certified: largest error {:.3g} <= {:.3g} at {} points", certificate.max_error,
                       certificate.tolerance, certificate.points);
  }
  if (certificate.failed_points > 0) {
    return fmt::format("the certificate is incomplete: {} of {} {}{}{}", certificate.failed_points,
                       certificate.points, of_command ? "points have no answer" : "integrations failed",
                       certificate.failure.empty() ? "" : ", the first with: ", certificate.failure);
  }
  const std::string error = fmt::format("largest error {:.3g} at {} points, tolerance {:.3g}",
                                        certificate.max_error, certificate.points, certificate.tolerance);
  if (record.status != "converged")
    return fmt::format("the build missed its tolerance: {}; {}", record.message, error);
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

/// The calls of a build by sampling, with those of its checkpoint if it is resumed. A disk that is full must
/// not end a build that needs no disk: it is told once.
CallMemory calls_of(const Plan& plan, SampledSource source, const BuildOptions& options) {
  std::vector<CallSheet> known;
  if (options.resume && is_checkpoint(options.checkpoint)) known = load_calls(options.checkpoint, plan.text);
  CallMemory::Save save;
  if (!options.checkpoint.empty()) {
    save = [&plan, &options, warned = false](const std::vector<CallSheet>& calls) mutable {
      try {
        save_calls(options.checkpoint, plan.text, calls, plan.box.size());
      } catch (const ArgumentError& error) {
        if (!warned && options.warning) options.warning(fmt::format("no checkpoint: {}", error.what()));
        warned = true;
      }
    };
  }
  try {
    return CallMemory(std::move(source), std::move(known), std::move(save));
  } catch (const ArgumentError& error) {
    throw bad_checkpoint(options.checkpoint, error.what());
  }
}

/// Nothing where the engine has no result or refuses the plan: what sampling found must not be lost for it.
std::optional<Solution> engine_trial(const Plan& plan, const models::ParametricModel& model,
                                     const BuildOptions& options, const ProgressCallback& progress) {
  try {
    return solve_by_pgd(plan, model, options, at_most(plan, kTrialEvaluations), progress);
  } catch (const NoResultError&) {
    return std::nullopt;
  } catch (const ArgumentError&) {
    return std::nullopt;
  }
}

/// Kind "auto": sampling, whose cost is known before it is spent, has the first trial, the PGD engine the
/// second. Both are counted, not timed, so that the choice is the same everywhere.
Solution solve_by_trial(const Plan& plan, const models::ParametricModel& model, const BuildOptions& options,
                        const ProgressCallback& progress, const bool& cancelled) {
  if (plan.prescribes_axes()) {
    return chosen(solve_by_pgd(plan, model, options, plan.builder.max_calls, progress),
                  "the plan prescribes an axis, and sampling chooses its own");
  }
  CallMemory calls = calls_of(plan, model_source(plan, model), options);
  Solution first = solve_by_sampling(plan, calls, at_most(plan, kTrialTrajectories), progress);
  const std::string& status = first.record.status;
  if (status == "converged")
    return chosen(std::move(first),
                  fmt::format("it needed no more than the {} trajectories of its trial", kTrialTrajectories));
  // Where there is no trajectory, no builder finds a solution.
  if (cancelled || status == "failed" || status == "not_finite") return first;
  std::optional<Solution> second = engine_trial(plan, model, options, progress);
  const std::string failed = fmt::format("sampling did not converge ({})", status);
  if (second && second->record.status == "converged") return chosen(std::move(*second), failed);
  const std::string neither = "neither builder converged in its trial, and the calls of sampling are bounded";
  if (cancelled || status != "max_calls") return chosen(std::move(first), neither);
  return chosen(solve_by_sampling(plan, calls, at_most(plan, kMostSampledCalls), progress), neither);
}

Solution solve(const Plan& plan, const models::ParametricModel& model, const BuildOptions& options,
               const ProgressCallback& progress, const bool& cancelled) {
  if (plan.builder.kind == "pgd") return solve_by_pgd(plan, model, options, plan.builder.max_calls, progress);
  if (plan.builder.kind == "auto") return solve_by_trial(plan, model, options, progress, cancelled);
  CallMemory calls = calls_of(plan, model_source(plan, model), options);
  return solve_by_sampling(plan, calls, at_most(plan, kMostSampledCalls), progress);
}

CertifyOptions certify_options(const Plan& plan, const BuildOptions& options,
                               const ProgressCallback& progress) {
  CertifyOptions result;
  result.points = plan.command ? plan.command->certificate_points : options.certificate_points;
  result.seed = options.certificate_seed;
  result.tolerance = plan.relative;
  result.absolute = plan.absolute;
  result.threads = plan.builder.threads;
  result.progress = progress;
  return result;
}

/// A codebook that waits for its certificate.
struct Uncertified {
  Codebook book;
  double residual = 0.0;
  ErrorBudget spent;
};

Uncertified book_of(const Plan& plan, ModelDescription model, Solution solution, Clock::time_point begin) {
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return {Codebook(std::move(model), std::move(solution.pieces), std::move(solution.record),
                   provenance_of(plan, seconds), {}, plan.title),
          solution.residual, solution.spent};
}

BuildResult finished(const Uncertified& built, Certificate certificate, bool cancelled) {
  const BuildRecord& record = built.book.build();
  certificate.met = certificate.met && record.status == "converged";
  certificate.residual = built.residual;
  certificate.spent = built.spent;
  const bool met = certificate.met;
  const bool of_command = built.book.is_of_command();
  std::string message = sentence(record, certificate, of_command, cancelled);
  const bool has_failed = of_command && (record.status == "failed" || certificate.failed_points > 0);
  return {built.book.with_certificate(std::move(certificate)), met, std::move(message),
          cancelled || has_failed};
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
  const Clock::time_point begin = Clock::now();
  const models::ParametricModel model = plan.parametric_model();
  warn_of_parameters(plan, model.model(), options);
  const Solution solved = solve(plan, model, options, progress, cancelled);
  const auto certified = [&](Solution solution) {
    const Uncertified built = book_of(plan, describe(model), std::move(solution), begin);
    Certificate certificate = certify(built.book, model, certify_options(plan, options, progress));
    return finished(built, std::move(certificate), cancelled);
  };
  // Fewer numbers must not cost the certificate.
  for (const double share : {0.9, 0.4}) {
    std::optional<Solution> compact = compacted(
        solved,
        {.tolerance = plan.relative, .share = share, .absolute = plan.absolute, .seed = plan.builder.seed});
    if (!compact) break;
    BuildResult result = certified(std::move(*compact));
    if (result.met || cancelled) return result;
  }
  return certified(solved);
}

/// A command that has failed is not called again for the certificate.
BuildResult build_of_command(const Plan& plan, const BuildOptions& options, const ProgressCallback& progress,
                             const bool& cancelled) {
  const Clock::time_point begin = Clock::now();
  CallMemory calls = calls_of(plan, command_source(plan), options);
  const Uncertified built =
      book_of(plan, describe(plan),
              solve_by_sampling(plan, calls, at_most(plan, kMostSampledCalls), progress), begin);
  const BuildRecord& record = built.book.build();
  CertifyOptions certify_by = certify_options(plan, options, progress);
  if (record.status == "failed") certify_by.progress = [](const Progress&) { return false; };
  Certificate certificate = certify(built.book, calls, certify_by);
  calls.save();
  if (record.status == "failed") certificate.failure = record.message;
  return finished(built, std::move(certificate), cancelled);
}

}  // namespace

BuildResult build(const Plan& plan, const BuildOptions& options) {
  // Once cancelled, always cancelled: neither solver nor certificate ask again.
  bool cancelled = false;
  ProgressCallback progress;
  if (options.progress) {
    progress = [&](const Progress& report) { return !(cancelled = cancelled || !options.progress(report)); };
  }
  BuildResult result = plan.command ? build_of_command(plan, options, progress, cancelled)
                                    : build_of_model(plan, options, progress, cancelled);
  if (!options.checkpoint.empty() && !options.keep_checkpoint && !result.resumable) {
    std::error_code ignored;
    std::filesystem::remove(options.checkpoint, ignored);
  }
  return result;
}

}  // namespace samara::codebooks
