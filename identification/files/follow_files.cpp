#include "samara/identification/files/follow_files.h"

#include <memory>
#include <optional>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/files/fit_source.h"
#include "samara/identification/following/noise_search.h"
#include "samara/identification/problem/fit_config.h"
#include "samara/identification/report/read_fit.h"

namespace samara::identification {

namespace {

std::shared_ptr<const models::Model> followed_model(const std::string& source) {
  if (is_model_source(source)) return codebooks::open_model(source);
  const codebooks::Codebook book = codebooks::load(source);
  const auto family = codebooks::codebook_trajectories(book);
  if (family->equations() == nullptr)
    throw InputError(source,
                     "a motion is followed with its equations, which are not known; a model was expected");
  return family->equations()->shared_model();
}

/// What a request says beside the fit.
FollowOptions requested_options(const models::Model& model, const FitResult& fitted, const Capture& capture,
                                const FollowRequest& request) {
  FollowOptions options = of_file(request.fit, [&] { return follow_options(model, fitted, capture); });
  std::vector<std::string> known;
  for (const auto& [name, noise] : options.noise) known.push_back(name);
  if (options.attitude_noise) known.emplace_back("attitude");
  const auto given =
      request.frame_noise ? request.frame_noise(model.info()) : std::map<std::string, double>();
  for (const auto& [name, noise] : given) {
    if (!contains(known, name)) {
      throw ArgumentError(fmt::format("the noise of \"{}\" was given, which is not measured{}", name,
                                      suggestion(name, known)));
    }
    if (name == "attitude") {
      options.attitude_noise = noise;
    } else {
      options.noise[name] = noise;
    }
  }
  if (request.step) options.step = *request.step;
  if (request.start_frames) options.start_frames = *request.start_frames;
  return options;
}

/// @param track that is followed: what comes in it must not be known beforehand
NoiseChoice chosen_noise(const std::shared_ptr<const models::Model>& model, const FitResult& fitted,
                         const Capture& track, const FollowRequest& request) {
  std::vector<Capture> captures;
  for (const std::filesystem::path& file : request.training) {
    for (Capture& capture : read_captures(file, request.sidecar)) {
      if (capture.id == track.id && is_same_file(capture.file, track.file)) {
        throw InputError(
            file.string(),
            fmt::format("capture \"{}\" is the track that is followed; training captures that it "
                        "is not among were expected",
                        capture.id));
      }
      captures.push_back(std::move(capture));
    }
  }
  refuse_repeated(captures, "given");
  std::vector<FollowOptions> options;
  for (const Capture& capture : captures)
    options.push_back(requested_options(*model, fitted, capture, request));
  const NoiseSearch search{
      .ahead = request.ahead, .stride = 0.5 * request.ahead, .progress = request.progress};
  return choose_noise(model, options, captures, without_given(search, request.noise));
}

/// Such noise would change nothing, and the model be taken as exact without a word.
void refuse_noise_of_no_state(const FollowReport& report) {
  const auto refuse_given = [&](const std::optional<double>& given, const char* of, const char* unit) {
    if (given.value_or(0.0) == 0.0) return;
    throw ArgumentError(fmt::format(
        "the noise of {} is {} {} per root of a second, but \"{}\" has no state in {}; none was expected", of,
        *given, unit, report.model, unit));
  };
  if (!report.has_velocities) refuse_given(report.given.velocity, "velocities (--velocity-noise)", "m/s");
  if (!report.has_rates) refuse_given(report.given.rate, "rates (--rate-noise)", "rad/s");
}

}  // namespace

FollowReport follow_files(const FollowRequest& request) {
  FitResult fitted = read_fit(request.fit);
  const auto model = followed_model(request.source);
  FollowReport report{.model = model->info().name,
                      .source = request.source,
                      .noise = as_given(request.noise),
                      .given = request.noise,
                      .has_velocities = has_noise(model->info(), &ModelNoise::velocity),
                      .has_rates = has_noise(model->info(), &ModelNoise::rate)};
  if (fitted.model != report.model) {
    throw InputError(request.fit.string(),
                     fmt::format("it is a fit of the model \"{}\"; one of \"{}\" was expected", fitted.model,
                                 report.model));
  }
  refuse_noise_of_no_state(report);
  if (!fitted.is_usable())
    report.warnings.add(WarningKind::source, fmt::format("{}: {}", request.fit.string(), fitted.message));
  report.warnings.add_all(warnings_of_coefficients(*model, fitted));
  if (!request.config.empty()) {
    const FitOptions config = read_fit_config(request.config, config_names(model->info()));
    fitted.setup.unknowns.known = config.unknowns.known;
    fitted.setup.solver.step = config.solver.step;
  }
  if (fitted.setup.camera.scale || fitted.setup.camera.rotation) {
    report.warnings.add(
        WarningKind::source,
        "the camera of the fit was not known for sure; here its lengths and axes are taken as right");
  }
  const std::vector<Capture> tracks = read_captures(request.track, request.sidecar);
  if (tracks.size() != 1) {
    throw InputError(request.track.string(),
                     fmt::format("it holds {} captures; one was expected (\"where\" in a sidecar chooses)",
                                 tracks.size()));
  }
  if (!request.training.empty()) {
    report.noise = chosen_noise(model, fitted, tracks.front(), request);
    report.noise_was_chosen = true;
  }
  if (report.noise.velocity == 0.0 && report.noise.rate == 0.0) {
    report.warnings.add(
        WarningKind::errors,
        "the model is taken as exact; errors hold where it is (captures to train on choose how far it is "
        "not)");
  }
  const FollowOptions options = requested_options(*model, fitted, tracks.front(), request);
  report.motion = follow(model, with_noise(options, report.noise), tracks.front(), request.ahead);
  add_follow_warnings(report);
  return report;
}

}  // namespace samara::identification
