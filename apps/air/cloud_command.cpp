#include "air/cloud_command.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "air/air_sources.h"
#include "air/cloud_animation.h"
#include "air/cloud_output.h"
#include "air/cloud_picture.h"
#include "air/winds.h"
#include "inputs/assignments.h"
#include "pictures/animation.h"
#include "samara/base/errors.h"
#include "samara/base/text.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/codebooks/source/realisation_checkpoint.h"
#include "samara/io/animated_scene.h"
#include "samara/io/atomic_file.h"
#include "samara/io/csv.h"
#include "samara/models/stochastic/gust_layout.h"
#include "samara/models/stochastic/realisations.h"
#include "terminal/interrupts.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

/// Unless --keep says otherwise.
constexpr long kMostAnimatedFlights = 1000;

/// `missing` where the option was not given.
template <class Whole>
Whole whole_from(const std::string& option, const std::string& text, Whole least, Whole missing = 0) {
  if (text.empty()) return missing;
  Whole value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || stop != end || value < least)
    throw ArgumentError(fmt::format("{} is {}, expected a whole number from {} on", option, text, least));
  return value;
}

/// The first option that only realisations understand.
std::string stray_word(const CloudWords& words, bool has_wind) {
  if (!words.turbulence.empty()) return "--turbulence";
  if (!words.flow.empty()) return "--flow";
  if (!words.speed.empty()) return "--speed";
  if (!words.length.empty()) return "--length";
  if (!words.place.empty()) return "--flow-place";
  if (!words.flow_at.empty()) return "--flow-set";
  if (!words.outside.empty()) return "--outside";
  if (!words.C_0.empty()) return "--C0";
  if (!words.radius.empty()) return "--body-radius";
  if (words.rotation) return "--rotation";
  if (!words.ground.empty()) return "--ground";
  if (!words.states.empty()) return "--states";
  if (!words.keep.empty()) return "--keep";
  if (!words.seed.empty() && !has_wind) return "--seed";
  if (!words.first.empty()) return "--first";
  if (!words.threads.empty()) return "--threads";
  if (words.antithetic) return "--antithetic";
  if (!words.relative_error.empty()) return "--relative-error";
  if (!words.picture.empty()) return "--picture";
  return "";
}

double length_from(const std::string& option, const std::string& text) {
  return number_or_quantity(option, text, "m");
}

/// A step resolves the body's own motion; that it resolves the air's is said afterwards.
double step_of(const SimulateArguments& arguments, const models::ParametricModel& model) {
  return arguments.step.empty() ? models::step_of_body(model, {})
                                : positive_quantity("--step", arguments.step, "s");
}

models::RealiseOptions options_of(const SimulateArguments& arguments, const models::ParametricModel& model) {
  const CloudWords& words = arguments.cloud;
  models::RealiseOptions options = {.realisations = whole_from("--realisations", words.realisations, 1L),
                                    .first = whole_from("--first", words.first, 0L),
                                    .step = step_of(arguments, model),
                                    .threads = whole_from("--threads", words.threads, 0),
                                    .states = words.states,
                                    .keep = whole_from("--keep", words.keep, 0L),
                                    .antithetic = words.antithetic,
                                    .progress = progress_line()};
  if (!words.ground.empty()) options.ground = length_from("--ground", words.ground);
  if (!words.relative_error.empty())
    options.relative_error = positive_quantity("--relative-error", words.relative_error, "1");
  // An animation is of all flights, as far as viewers bear them.
  if (io::is_scene_name(arguments.output) && words.keep.empty())
    options.keep = std::min(options.realisations, kMostAnimatedFlights);
  // A picture shows some paths.
  if (!words.picture.empty()) options.keep = std::max(options.keep, kPathsInPicture);
  return options;
}

/// The body's own, unless another was given.
double radius_of(const SimulateArguments& arguments, const models::ParametricModel& model) {
  const std::string& text = arguments.cloud.radius;
  if (text.empty()) return models::outline_radius(model.model().info(), model.parameters({}));
  const double radius = length_from("--body-radius", text);
  if (!(radius >= 0.0)) throw ArgumentError(fmt::format("--body-radius is {}, expected 0 or more", text));
  return radius;
}

void check_outputs(const SimulateArguments& arguments) {
  for (const std::string* path : {&arguments.output, &arguments.cloud.picture}) {
    if (!path->empty()) check_output(*path, {arguments.model, arguments.wind, arguments.cloud.flow});
  }
  check_ending("--picture", arguments.cloud.picture, ".svg");
  const std::string ending = ending_of(arguments.output);
  const bool is_animation = io::is_scene_name(arguments.output);
  if (!arguments.output.empty() && ending != ".h5" && ending != ".csv" && !is_animation)
    throw ArgumentError(fmt::format("--output is {}, expected a name that ends in .csv, .h5, .glb or .usda",
                                    arguments.output));
  if (ending == ".h5") {
    check_file_output(arguments.output, {});
    check_replaced_hdf5(arguments.output, "cloud", kCloudFormat);
  }
  if (ending != ".h5" && !is_animation && !arguments.cloud.keep.empty())
    throw ArgumentError("--keep: trajectories go into a file that ends in .h5, .glb or .usda, with --output");
  if (is_animation && whole_from("--keep", arguments.cloud.keep, 0L, 1L) < 1)
    throw ArgumentError(
        "--keep is 0, and an animation is of the flights that are kept: 1 or more were expected");
}

/// Before anything is allocated: what a wave of 256 realisations, the sums and the kept trajectories take.
void check_memory(const models::RealiseOptions& options, Eigen::Index frames, const models::ModelInfo& info) {
  constexpr double kMostBytes = 2e9;
  const double states = options.states.empty() ? 3.0 : static_cast<double>(options.states.size());
  const auto kept = static_cast<double>(std::min(options.keep, options.realisations));
  const double values =
      256.0 * states + 30.0 * states * states + kept * static_cast<double>(info.states.size());
  const double bytes = sizeof(double) * values * static_cast<double>(frames);
  if (bytes > kMostBytes) {
    throw ArgumentError(
        fmt::format("--frames is {} with {} trajectories to keep, which would take {:.1f} GB; at most "
                    "{:.0f} frames were expected",
                    frames, kept, 1e-9 * bytes, kMostBytes / (sizeof(double) * values)));
  }
}

void warn_of_steps(const models::Ensemble& cloud) {
  constexpr const char* kOption = "--step ";
  if (const std::string doubt = models::doubt_of_steps(cloud, kOption); !doubt.empty()) {
    warn(doubt);
  } else if (cloud.steps.beyond_tenth > 0.05) {
    narrate(fmt::format(
        "{:.0f} % of the steps are longer than a tenth of the time in which the air changes, which matters "
        "where its energy has a gradient; {}",
        100.0 * cloud.steps.beyond_tenth, models::better_step(cloud, kOption)));
  }
}

/// Where what is done is kept; nowhere without a file to write, or where an input is a pipe.
codebooks::RealisationCheckpoint checkpoint_of(const std::string& output, const NamedAir& air) {
  if (output.empty() || air.identity.empty()) return {};
  return {.file = output + ".checkpoint",
          .keep = true,
          .air = air.identity,
          .note = [](const std::string& sentence) { narrate(sentence); },
          .warning = [](const std::string& sentence) { warn(sentence); }};
}

}  // namespace

std::uint64_t seed_of(const CloudWords& words) {
  return whole_from("--seed", words.seed, std::uint64_t{0}, std::uint64_t{1});
}

void check_cloud_words(const SimulateArguments& arguments) {
  const CloudWords& words = arguments.cloud;
  if (words.realisations.empty()) {
    const std::string stray = stray_word(words, !arguments.wind.empty());
    if (!stray.empty())
      throw ArgumentError(fmt::format("{} is of realisations: --realisations was expected", stray));
    return;
  }
  whole_from("--realisations", words.realisations, 1L);
  seed_of(words);
  const bool is_placed = !words.speed.empty() || !words.length.empty() || !words.place.empty() ||
                         !words.flow_at.empty() || !words.outside.empty();
  if (is_placed && words.flow.empty())
    throw ArgumentError(
        "--speed, --length, --flow-place, --flow-set and --outside are of --flow, which was expected");
  if (!words.outside.empty() && words.outside != "end" && words.outside != "stream")
    throw ArgumentError(fmt::format("--outside is {}, expected end or stream", words.outside));
  if (!words.flow.empty() && (words.speed.empty() || words.length.empty()))
    throw ArgumentError("--flow is dimensionless: --speed and --length were expected with it");
  if (!has_air(arguments)) {
    throw ArgumentError(
        fmt::format("--realisations is {} without a flow that differs between them: --turbulence, --flow or "
                    "--wind was expected",
                    words.realisations));
  }
  if (arguments.integrator != "cvodes" && arguments.integrator != "rk4")
    throw ArgumentError(
        fmt::format("--integrator is {}: realisations take steps of rk4", arguments.integrator));
  if (arguments.forces)
    throw ArgumentError("--forces is of single trajectories: no --realisations was expected");
  if (!arguments.coefficients.empty())
    throw ArgumentError("--coefficients is of single trajectories: no --realisations was expected");
}

int fly_cloud(const SimulateArguments& arguments, const models::ParametricModel& model,
              const Eigen::VectorXd& times) {
  const models::RealiseOptions options = options_of(arguments, model);
  check_outputs(arguments);
  std::optional<models::TriangleMesh> body;
  if (io::is_scene_name(arguments.output)) {
    animated_states(model.model().info());
    body = animated_body({arguments.body.body, arguments.body.sizes, arguments.body.unit}, model, {});
  }
  check_memory(options, times.size(), model.model().info());
  const std::uint64_t seed = seed_of(arguments.cloud);
  const models::GustLayout layout(model.model());
  const double radius = radius_of(arguments, model);
  const NamedAir air = air_of(arguments, model, seed, radius);
  catch_interrupts();
  const codebooks::RealisationCheckpoint checkpoint = checkpoint_of(arguments.output, air);
  models::Ensemble cloud = codebooks::realise(
      model, {}, *air.source, {times.data(), static_cast<std::size_t>(times.size())}, options, checkpoint);
  clear_progress();
  if (cloud.realisations() == 0) {
    warn("interrupted before the first 256 realisations were done");
    return kInterrupted;
  }
  warn_of_steps(cloud);
  warn_of_gusts(air.shortest_gust, options.step);
  std::string picture;
  if (!arguments.cloud.picture.empty()) picture = cloud_picture(cloud, layout, options.ground);
  // Those that only the picture wanted.
  const long wanted = whole_from("--keep", arguments.cloud.keep, 0L, body ? kMostAnimatedFlights : 0L);
  cloud.kept.resize(std::min(cloud.kept.size(), static_cast<std::size_t>(wanted)));
  const CloudFile file = {.cloud = cloud,
                          .model = model,
                          .seed = seed,
                          .step = options.step,
                          .ground = options.ground,
                          .body_radius = radius,
                          .C_0 = arguments.cloud.C_0,
                          .rotation = arguments.cloud.rotation,
                          .air = air.description};
  if (body) {
    if (arguments.cloud.keep.empty() && cloud.realisations() > kMostAnimatedFlights)
      narrate(fmt::format("the first {} flights are animated, --keep says otherwise", kMostAnimatedFlights));
    write_cloud_animation(arguments.output, file, *body);
  } else if (ending_of(arguments.output) == ".h5") {
    write_cloud(arguments.output, file);
  } else if (!arguments.output.empty() || !arguments.cloud.json) {
    const CloudTable table = cloud_table(cloud);
    write_answer(arguments.output, io::format_csv(table.header, table.rows));
  }
  if (!arguments.cloud.picture.empty()) io::write_text_atomically(arguments.cloud.picture, picture);
  std::error_code ignored;
  if (!cloud.cancelled && !checkpoint.file.empty()) std::filesystem::remove(checkpoint.file, ignored);
  if (arguments.cloud.json) print(cloud_json(file));
  narrate(cloud_summary(file, layout));
  if (!cloud.cancelled)
    return cloud.count(models::RealisationStatus::not_finite) > 0 ? kToleranceMissed : kDone;
  if (!arguments.output.empty() && codebooks::is_checkpoint(arguments.output + ".checkpoint"))
    narrate(
        fmt::format("{}.checkpoint keeps what is done: the same line goes on from there", arguments.output));
  return kInterrupted;
}

}  // namespace samara::apps
