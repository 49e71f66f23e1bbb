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

/// Evaluations the PGD engine may use in the trial of a plan of kind "auto".
constexpr long kTrialEvaluations = 300'000;

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

/// The PGD engine, unless it does not get there within a trial: then sampling.
Solution solve_by_trial(const Plan& plan, const models::ParametricModel& model, const BuildOptions& options,
                        const ProgressCallback& progress, const bool& cancelled) {
  const long most = plan.builder.max_calls;
  if (prescribes_axes(plan)) {
    Solution solution = solve_by_pgd(plan, model, options, most, progress);
    solution.record.message += "; chosen because the plan prescribes an axis";
    return solution;
  }
  Solution solution = solve_by_pgd(plan, model, options, kTrialEvaluations, progress);
  if (solution.record.status == "converged" || cancelled) {
    solution.record.message += "; chosen because it converged within its trial";
    return solution;
  }
  const std::string trial = fmt::format("the PGD engine did not converge in a trial of {:.3g} evaluations",
                                        solution.record.evaluations);
  solution = solve_by_sampling(plan, model, progress);
  solution.record.message += fmt::format("; chosen because {}", trial);
  return solution;
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
  return solve_by_sampling(plan, model, progress);
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
  Codebook book(describe(model), {std::move(solution.piece)}, solution.record, provenance_of(plan, seconds),
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
