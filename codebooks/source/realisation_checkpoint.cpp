#include "samara/codebooks/source/realisation_checkpoint.h"

#include <optional>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/base/errors.h"
#include "samara/codebooks/source/checkpoint.h"

namespace samara::codebooks {

namespace {

/// All that the flights depend on.
std::string text_of_call(const models::ParametricModel& model, std::span<const double> point,
                         std::span<const double> times, const models::RealiseOptions& options,
                         const std::string& air) {
  const models::ModelInfo& info = model.model().info();
  const std::vector<double> parameters = model.parameters(point);
  std::vector<double> start(static_cast<std::size_t>(model.state_count()));
  model.initial(point, start);
  std::string text = fmt::format("realisations of {}\n{}\n", info.name, info.equations);
  text += fmt::format("parameters {}\nstart {}\ntimes {}\n", fmt::join(parameters, " "),
                      fmt::join(start, " "), fmt::join(times, " "));
  text += fmt::format("step {}, first {}, keep {}, antithetic {}\n", options.step, options.first,
                      options.keep, options.antithetic);
  text += options.ground ? fmt::format("ground {}\n", *options.ground) : std::string("no ground\n");
  text += fmt::format("states {}, up to {}\n", fmt::join(options.states, " "), options.relative_error);
  return text + "air " + air;
}

}  // namespace

models::Ensemble realise(const models::ParametricModel& model, std::span<const double> point,
                         const models::AirSource& air, std::span<const double> times,
                         const models::RealiseOptions& options, const RealisationCheckpoint& checkpoint) {
  if (checkpoint.file.empty()) return models::realise(model, point, air, times, options);
  // First: with options that are wrong any checkpoint would seem to be of another call.
  models::check_realisations(model, point, air, times, options);
  Checkpoint file(checkpoint.file, text_of_call(model, point, times, options, checkpoint.air));
  const auto note = [&](const std::string& sentence) {
    if (checkpoint.note) checkpoint.note(sentence);
  };
  std::optional<models::Ensemble> begun;
  if (is_checkpoint(checkpoint.file)) {
    try {
      begun = models::ensemble_of(file.march(), model, point, air, times, options);
      if (begun->realisations() > options.realisations) throw ArgumentError("it has more than are asked for");
      note(fmt::format("{} holds {} realisations of this call, which goes on from there",
                       checkpoint.file.string(), begun->realisations()));
    } catch (const Error&) {
      begun.reset();
      note(fmt::format("{} is of another call, and is replaced", checkpoint.file.string()));
    }
  }
  models::RealiseOptions keeping = options;
  const auto keep = told_once<models::Ensemble>(
      [&](const models::Ensemble& cloud) { file.save_march(models::numbers_of(cloud)); }, checkpoint.warning);
  keeping.so_far = [&](const models::Ensemble& cloud) {
    keep(cloud);
    if (options.so_far) options.so_far(cloud);
  };
  models::Ensemble cloud = begun ? models::resume(*begun, model, point, air, times, keeping)
                                 : models::realise(model, point, air, times, keeping);
  std::error_code ignored;
  if (!cloud.cancelled && !checkpoint.keep) std::filesystem::remove(checkpoint.file, ignored);
  return cloud;
}

}  // namespace samara::codebooks
