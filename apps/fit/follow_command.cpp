#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "inputs/assignments.h"
#include "options/commands.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/files/follow_files.h"
#include "samara/io/atomic_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

namespace id = samara::identification;

/// SI; 0 where the command does not say.
double amount_of(const std::string& option, const std::string& text, const std::string& unit) {
  if (text.empty()) return 0.0;
  const double value = number_or_quantity(option, text, unit);
  if (value >= 0.0 && std::isfinite(value)) return value;
  throw ArgumentError(fmt::format("{} is {}; 0 or more was expected", option, text));
}

/// Of outputs, and of the attitude.
std::map<std::string, double> noise_of(const FollowArguments& arguments, const models::ModelInfo& model) {
  std::map<std::string, std::string> units = {{"attitude", "rad"}};
  for (const models::StateInfo& state : model.states) units[state.name] = state.unit;
  for (const models::OutputInfo& output : model.outputs) units[output.name] = output.unit;
  std::map<std::string, double> noise;
  for (const std::string& given : arguments.noise) {
    const auto [name, text] = setting_of("--noise", given);
    const auto unit = units.find(name);
    if (unit == units.end())
      throw ArgumentError(fmt::format("--noise: the model \"{}\" has no output \"{}\"", model.name, name));
    if (!noise.emplace(name, number_or_difference(name, text, unit->second)).second)
      throw ArgumentError(fmt::format("--noise: \"{}\" is given twice", name));
  }
  return noise;
}

id::FollowRequest request_of(const FollowArguments& arguments) {
  id::FollowRequest request{.source = arguments.source,
                            .fit = arguments.fit,
                            .track = arguments.track,
                            .sidecar = arguments.sidecar,
                            .config = arguments.config,
                            .ahead = amount_of("--ahead", arguments.ahead, "s"),
                            .start_frames = arguments.start_frames,
                            .progress = progress_line()};
  request.training.assign(arguments.training.begin(), arguments.training.end());
  if (!arguments.step.empty()) request.step = amount_of("--step", arguments.step, "s");
  request.noise.velocity = amount_of("--velocity-noise", arguments.velocity_noise, "m/s");
  request.noise.rate = amount_of("--rate-noise", arguments.rate_noise, "rad/s");
  request.noise.spread = amount_of("--spread", arguments.spread, "1");
  request.noise.drift = amount_of("--drift", arguments.drift, "1");
  request.frame_noise = [&](const models::ModelInfo& model) { return noise_of(arguments, model); };
  return request;
}

/// Before any work: what would be overwritten, or cannot be written.
void check_files(const FollowArguments& arguments) {
  if (arguments.output.empty()) return;
  std::vector<std::string> inputs = {arguments.source, arguments.fit, arguments.config, arguments.sidecar};
  const auto add = [&](const std::string& track) {
    const auto files =
        arguments.sidecar.empty() ? id::capture_files(track) : id::capture_files(track, arguments.sidecar);
    for (const std::filesystem::path& file : files) inputs.push_back(file.string());
  };
  add(arguments.track);
  for (const std::string& track : arguments.training) add(track);
  check_output(arguments.output, inputs);
}

}  // namespace

int run(const FollowArguments& arguments) {
  const id::FollowRequest request = request_of(arguments);
  check_files(arguments);
  const id::FollowReport report = id::follow_files(request);
  clear_progress();
  for (const std::string& sentence : report.warnings) warn(sentence);
  if (!arguments.output.empty()) io::write_text_atomically(arguments.output, id::follow_csv(report));
  print(arguments.json ? id::follow_json(report) : printable(id::follow_text(report), "\n"));
  return kDone;
}

}  // namespace samara::apps
