#include "samara/codebooks/build.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <system_error>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include "samara/base/errors.h"
#include "samara/base/version.h"
#include "samara/codebooks/certify.h"
#include "samara/codebooks/pgd_builder.h"
#include "samara/codebooks/sampling_builder.h"

namespace samara::codebooks {

namespace {

// What the trials of a plan of kind "auto" may use.
constexpr long kTrialTrajectories = 5000;
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

Provenance provenance_of(const Plan& plan, double seconds) {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return {fmt::format("samara {}", version()), plan.text,
          fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))), host.data(), seconds};
}

std::string sentence(const BuildRecord& record, const Certificate& certificate, bool cancelled) {
  if (cancelled) {
    return fmt::format("the build was cancelled; its certificate covers {} of {} points",
                       certificate.points - certificate.failed_points, certificate.points);
  }
  if (certificate.met) {
    return fmt::format("certified: largest error {:.3g} <= {:.3g} at {} points", certificate.max_error,
                       certificate.tolerance, certificate.points);
  }
  if (certificate.failed_points > 0) {
    return fmt::format("the certificate is incomplete: {} of {} integrations failed{}{}",
                       certificate.failed_points, certificate.points,
                       certificate.failure.empty() ? "" : ", the first with: ", certificate.failure);
  }
  const std::string error = fmt::format("largest error {:.3g} at {} points, tolerance {:.3g}",
                                        certificate.max_error, certificate.points, certificate.tolerance);
  if (record.status != "converged")
    return fmt::format("the build missed its tolerance: {}; {}", record.message, error);
  return fmt::format("the build missed its tolerance: {}", error);
}

}  // namespace

namespace {

/// Whether the plan says how an axis is to be discretised, which sampling does by itself.
bool prescribes_axes(const Plan& plan) {
  return std::any_of(plan.box.begin(), plan.box.end(), [](const BoxEntry& entry) {
    return entry.nodes || entry.basis != pgd::Basis::chebyshev;
  });
}

/// `limit` or the plan's own, whichever is less.
long at_most(const Plan& plan, long limit) {
  return plan.builder.max_calls > 0 ? std::min(plan.builder.max_calls, limit) : limit;
}

Solution chosen(Solution solution, const std::string& reason) {
  solution.record.message += fmt::format("; chosen because {}", reason);
  return solution;
}

/// Kind "auto": sampling, whose cost is known before it is spent, has the first trial, the PGD engine the
/// second. Both are counted, not timed, so that the choice is the same everywhere.
Solution solve_by_trial(const Plan& plan, const models::ParametricModel& model, const BuildOptions& options,
                        const ProgressCallback& progress, const bool& cancelled) {
  if (prescribes_axes(plan)) {
    return chosen(solve_by_pgd(plan, model, options, plan.builder.max_calls, progress),
                  "the plan prescribes an axis, and sampling chooses its own");
  }
  Solution first = solve_by_sampling(plan, model, at_most(plan, kTrialTrajectories), progress);
  const std::string& status = first.record.status;
  if (status == "converged")
    return chosen(std::move(first),
                  fmt::format("it needed no more than the {} trajectories of its trial", kTrialTrajectories));
  // Where there is no trajectory, no builder finds a solution.
  if (cancelled || status == "failed" || status == "not_finite") return first;
  Solution second = solve_by_pgd(plan, model, options, at_most(plan, kTrialEvaluations), progress);
  const std::string failed = fmt::format("sampling did not converge ({})", status);
  if (second.record.status == "converged") return chosen(std::move(second), failed);
  const std::string neither = "neither builder converged in its trial, and the calls of sampling are bounded";
  if (cancelled || status != "max_calls") return chosen(std::move(first), neither);
  return chosen(solve_by_sampling(plan, model, at_most(plan, kMostTrajectories), progress), neither);
}

Solution solve(const Plan& plan, const models::ParametricModel& model, const BuildOptions& options,
               const ProgressCallback& progress, const bool& cancelled) {
  if (plan.builder.kind == "pgd") return solve_by_pgd(plan, model, options, plan.builder.max_calls, progress);
  if (plan.builder.kind == "auto") return solve_by_trial(plan, model, options, progress, cancelled);
  if (options.resume && std::filesystem::exists(options.checkpoint)) {
    throw ArgumentError(fmt::format(
        "{}: a build by sampling keeps no checkpoint, so it cannot be resumed; remove the file or "
        "build without --resume",
        options.checkpoint.string()));
  }
  return solve_by_sampling(plan, model, at_most(plan, kMostTrajectories), progress);
}

}  // namespace

BuildResult build(const Plan& plan, const BuildOptions& options) {
  const Clock::time_point begin = Clock::now();
  const models::ParametricModel model = plan.parametric_model();
  // Once cancelled, always cancelled: neither solver nor certificate ask again.
  bool cancelled = false;
  ProgressCallback progress;
  if (options.progress) {
    progress = [&](const Progress& report) { return !(cancelled = cancelled || !options.progress(report)); };
  }
  Solution solution = solve(plan, model, options, progress, cancelled);
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  Codebook book(describe(model), std::move(solution.pieces), solution.record, provenance_of(plan, seconds),
                {}, plan.title);
  CertifyOptions certify_options;
  certify_options.points = options.certificate_points;
  certify_options.seed = options.certificate_seed;
  certify_options.tolerance = plan.relative;
  certify_options.absolute = plan.absolute;
  certify_options.threads = plan.builder.threads;
  certify_options.progress = progress;
  Certificate certificate = certify(book, model, certify_options);
  certificate.met = certificate.met && solution.record.status == "converged";
  certificate.residual = solution.residual;
  certificate.spent = solution.spent;
  const bool met = certificate.met;
  std::string message = sentence(solution.record, certificate, cancelled);
  if (!options.checkpoint.empty() && !options.keep_checkpoint && !cancelled) {
    std::error_code ignored;
    std::filesystem::remove(options.checkpoint, ignored);
  }
  return {book.with_certificate(std::move(certificate)), met, std::move(message)};
}

}  // namespace samara::codebooks
