#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "inputs/assignments.h"
#include "inputs/capture_inputs.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/files/follow_files.h"
#include "samara/io/atomic_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"
#include "terminal/text_layout.h"

namespace samara::apps {

namespace {

namespace id = samara::identification;

struct FollowArguments {
  std::string source;  ///< model, or codebook file
  std::string fit;     ///< JSON
  std::string track;
  std::string sidecar;
  std::string config;
  std::vector<std::string> training;
  std::string ahead;  ///< empty: no forecasts
  std::vector<std::string> noise;
  std::string velocity_noise, rate_noise, spread, drift, step;
  std::optional<int> start_frames;
  std::string output;
  bool json = false;
};

/// SI; empty where the command does not say.
std::optional<double> amount_of(const std::string& option, const std::string& text, const std::string& unit) {
  if (text.empty()) return {};
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
                            .ahead = amount_of("--ahead", arguments.ahead, "s").value_or(0.0),
                            .step = amount_of("--step", arguments.step, "s"),
                            .start_frames = arguments.start_frames,
                            .progress = progress_line()};
  request.training.assign(arguments.training.begin(), arguments.training.end());
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
  std::vector<std::string> tracks = arguments.training;
  tracks.push_back(arguments.track);
  std::vector<std::string> inputs = files_of_captures(tracks, arguments.sidecar);
  inputs.insert(inputs.end(), {arguments.source, arguments.fit, arguments.config});
  check_text_output(arguments.output, inputs, ".csv");
}

int run_follow(const FollowArguments& arguments) {
  const id::FollowRequest request = request_of(arguments);
  check_files(arguments);
  const id::FollowReport report = id::follow_files(request);
  clear_progress();
  for (const id::Warning& warning : report.warnings) warn(warning.sentence);
  if (!arguments.output.empty()) io::write_text_atomically(arguments.output, id::follow_csv(report));
  print(arguments.json ? id::follow_json(report) : wrapped_prose(printable(id::follow_text(report), "\n")));
  return id::is_followed_to_end(report) ? kDone : kToleranceMissed;
}

}  // namespace

void add_follow(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<FollowArguments>();
  CLI::App* command = app.add_subcommand(
      "follow", "a motion frame by frame with a fitted model: state, coefficients, and what comes next");
  command
      ->add_option("SOURCE", values->source,
                   "a model by its name or its file of equations, or a codebook file")
      ->required();
  command->add_option("FIT", values->fit, "JSON of a fit of it (samara fit -o)")->required();
  command
      ->add_option("TRACK", values->track, "what was measured: a table, or a sidecar (.toml) that maps one")
      ->required();
  command->add_option("--sidecar", values->sidecar,
                      "what the columns of all tables given are, TOML, in place of sidecars beside them");
  command->add_option("--config", values->config,
                      "of the fit, TOML: where [known] finds values of the capture, and the step");
  command->add_option("--ahead", values->ahead,
                      "also forecast so far beyond every frame, s or with a unit: a mean and a band of 90 %");
  command->add_option("--train", values->training,
                      "captures on which the noise of model and frames, spread and drift are chosen, but for "
                      "what is given of these; one or more");
  command
      ->add_option(
          "--noise", values->noise,
          "of frames of an output, NAME=VALUE; default: what the fit found; --train finds a factor of it")
      ->allow_extra_args(false);
  command->add_option(
      "--velocity-noise", values->velocity_noise,
      "what the model lacks: white noise in the rates of velocities, m/s per root of a second");
  command->add_option("--rate-noise", values->rate_noise,
                      "likewise in the rates of rates of rotation, rad/s per root of a second");
  command->add_option("--spread", values->spread,
                      "how far coefficients of one motion lie from those of the fit: 0.1 is 10 %");
  command->add_option("--drift", values->drift, "of coefficients, per root of a second: 0.1 is 10 %");
  command->add_option("--step", values->step, "of the integration at most, s or with a unit; default: 2 ms");
  command->add_option("--start-frames", values->start_frames, "from which the start is found; default: 8")
      ->check(whole_number());
  command->add_option("-o,--output", values->output,
                      "also write a table with a row a frame to this file, CSV");
  command->add_flag("--json", values->json, "print one JSON object instead of the text");
  on_call(*command, arguments, values, run_follow);
}

}  // namespace samara::apps
