#include "air/air_sources.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "air/winds.h"
#include "inputs/assignments.h"
#include "inputs/flows.h"
#include "samara/base/errors.h"
#include "samara/codebooks/model/wind_file.h"
#include "samara/flow/files/flow_view.h"
#include "samara/io/checksum.h"
#include "samara/io/text_file.h"
#include "samara/models/stochastic/fluid_seen.h"
#include "samara/models/stochastic/gust_layout.h"
#include "samara/models/wind/body_outline.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

/// "uniform" or "decaying", and what else --turbulence says.
struct TurbulenceWords {
  bool decays = false;
  std::map<std::string, double> values;

  std::optional<double> value(const std::string& name) const {
    const auto found = values.find(name);
    return found == values.end() ? std::nullopt : std::optional(found->second);
  }
};

TurbulenceWords words_of(const std::vector<std::string>& texts) {
  TurbulenceWords words;
  std::vector<std::string> settings = texts;
  if (texts[0].find('=') == std::string::npos) {
    if (texts[0] != "uniform" && texts[0] != "decaying")
      throw ArgumentError(fmt::format("--turbulence is {}, expected uniform or decaying", texts[0]));
    words.decays = texts[0] == "decaying";
    settings.erase(settings.begin());
  }
  words.values = parse_assignments(settings,
                                   {{"k", "m^2/s^2"},
                                    {"deviation", "m/s"},
                                    {"epsilon", "m^2/s^3"},
                                    {"scale", "m"},
                                    {"stream_x", "m/s"},
                                    {"stream_y", "m/s"},
                                    {"stream_z", "m/s"}},
                                   "--turbulence");
  return words;
}

/// The one of two names that was given.
/// @throws ArgumentError if none or both were
double one_of(const TurbulenceWords& words, const std::string& direct, const std::string& other,
              const auto& from_other) {
  const std::optional<double> given = words.value(direct), instead = words.value(other);
  if (given.has_value() == instead.has_value()) {
    throw ArgumentError(fmt::format("--turbulence has {} of {} and {}, one was expected",
                                    given ? "both" : "neither", direct, other));
  }
  return given ? *given : from_other(*instead);
}

/// Positive, or zero where it may vanish.
void check(const TurbulenceWords& words, const std::string& name, const char* unit, bool may_vanish) {
  const std::optional<double> value = words.value(name);
  if (value && !(*value > 0.0) && !(may_vanish && *value == 0.0)) {
    throw ArgumentError(fmt::format("--turbulence: {} is {} {}, expected {}", name, *value, unit,
                                    may_vanish ? "0 or more" : "more than 0"));
  }
}

models::SeenOptions seen_options(const SimulateArguments& arguments, const models::ParametricModel& model,
                                 double body_radius) {
  models::SeenOptions seen = {.radius = body_radius, .rotation = arguments.cloud.rotation};
  // Of the fluid that the body is in; that of air where a model does not say.
  const std::vector<models::ParameterInfo>& parameters = model.model().info().parameters;
  const auto nu = std::ranges::find(parameters, "nu", &models::ParameterInfo::name);
  if (nu != parameters.end())
    seen.viscosity = model.parameters({})[static_cast<std::size_t>(nu - parameters.begin())];
  if (arguments.cloud.C_0.empty()) return seen;
  seen.C_0 = positive_quantity("--C0", arguments.cloud.C_0, "1");
  return seen;
}

NamedAir wind_of(const SimulateArguments& arguments, const models::ParametricModel& model, std::uint64_t seed,
                 double body_radius) {
  const CloudWords& words = arguments.cloud;
  if (!words.turbulence.empty())
    throw ArgumentError("--turbulence says another air than --wind: one was expected");
  const codebooks::WindFile file = codebooks::read_wind(arguments.wind);
  const std::string description = "wind of " + arguments.wind;
  if (file.seen) {
    const auto layer = models::wind::surface_layer(file.wind.profile, file.wind.towards, *file.seen);
    return {.source = models::fluid_seen_in(layer, seed, seen_options(arguments, model, body_radius)),
            .description = description};
  }
  if (!file.wind.turbulence)
    warn(fmt::format("{} holds no [turbulence]: all realisations are one", arguments.wind));
  if (!words.C_0.empty() || words.rotation) {
    throw ArgumentError(fmt::format("{} is of fluid that is seen, and {} holds a field: none was expected",
                                    words.rotation ? "--rotation" : "--C0", arguments.wind));
  }
  std::optional<double> radius;
  if (!words.radius.empty()) radius = body_radius;
  const models::wind::BodyOutline body = models::wind::outline_of(model, radius);
  return {.source = models::wind::wind_air(file.wind, body.length, body.semi_axes, seed),
          .description = description,
          .shortest_gust = shortest_gust(file.wind)};
}

NamedAir wake_of(const SimulateArguments& arguments, const models::ParametricModel& model, std::uint64_t seed,
                 double body_radius) {
  const CloudWords& words = arguments.cloud;
  flow::FlowPlacement placement = {.speed = positive_quantity("--speed", words.speed, "m/s"),
                                   .length = positive_quantity("--length", words.length, "m"),
                                   .stream_beyond = words.outside == "stream"};
  if (!words.place.empty()) placement.body = place_of("--flow-place", words.place, "x, y, z");
  const auto stored =
      std::make_shared<const flow::StoredFlow>(flow_of_file(words.flow, words.flow_at, "--flow-set"));
  if (std::ranges::none_of(stored->fields, [](const auto& field) { return field.name == "epsilon"; })) {
    throw ArgumentError(fmt::format(
        "--flow: {} is laminar, so that all realisations would be one; a flow by k-epsilon was expected",
        words.flow));
  }
  if (stored->grid.dimensions == 3 &&
      models::GustLayout(model.model()).space() == models::GustLayout::Space::plane) {
    throw ArgumentError(
        fmt::format("--flow: {} is a flow in space, and model \"{}\" moves in a plane; the flow of a section "
                    "was expected",
                    words.flow, model.model().info().name));
  }
  if (stored->summary.status == flow::to_string(flow::FlowStatus::max_time))
    warn(fmt::format("--flow: {} was not finished: {}", words.flow, stored->summary.message));
  const auto view = std::make_shared<const flow::FlowView>(stored, placement);
  flow::check_release(*view, model);
  return {.source = models::fluid_seen_in(view, seed, seen_options(arguments, model, body_radius)),
          .description = fmt::format("the flow of {} at {:.6g} m/s and {:.6g} m{}", words.flow,
                                     placement.speed, placement.length,
                                     placement.stream_beyond ? ", in the stream beyond its grid" : "")};
}

NamedAir turbulence_of(const SimulateArguments& arguments, const models::ParametricModel& model,
                       std::uint64_t seed, double body_radius) {
  const TurbulenceWords words = words_of(arguments.cloud.turbulence);
  check(words, "k", "m^2/s^2", true);
  check(words, "deviation", "m/s", true);
  check(words, "epsilon", "m^2/s^3", false);
  check(words, "scale", "m", false);
  const double k =
      one_of(words, "k", "deviation", [](double deviation) { return 1.5 * deviation * deviation; });
  // L = 0.43 k^(3/2)/epsilon; without any energy the scale says nothing.
  const double epsilon = one_of(words, "epsilon", "scale", [k](double scale) {
    return k > 0.0 ? 0.43 * std::pow(k, 1.5) / scale : 1.0;
  });
  const Eigen::Vector3d stream(words.value("stream_x").value_or(0.0), words.value("stream_y").value_or(0.0),
                               words.value("stream_z").value_or(0.0));
  const auto flow = words.decays ? models::decaying_turbulence(k, epsilon, stream)
                                 : models::uniform_turbulence(k, epsilon, stream);
  return {
      models::fluid_seen_in(flow, seed, seen_options(arguments, model, body_radius)),
      fmt::format(
          "{} turbulence, k = {:.6g} m^2/s^2, epsilon = {:.6g} m^2/s^3, stream ({:.6g}, {:.6g}, {:.6g}) m/s",
          words.decays ? "decaying" : "uniform", k, epsilon, stream.x(), stream.y(), stream.z())};
}

std::string identity_of(const SimulateArguments& arguments, const std::string& description,
                        std::uint64_t seed, double body_radius) {
  const CloudWords& words = arguments.cloud;
  std::string text = fmt::format("{}, seed {}, radius {}, C_0 {}, rotation {}\n", description, seed,
                                 body_radius, words.C_0, words.rotation);
  // The description has rounded what these say.
  text += fmt::format("speed {}, length {}, at {}, {}, turbulence {}\n", words.speed, words.length,
                      words.place, fmt::join(words.flow_at, " "), fmt::join(words.turbulence, " "));
  for (const std::string& file : {arguments.wind, words.flow}) {
    if (file.empty()) continue;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored)) return "";
    // The files may have changed since.
    const std::string content = io::read_text_file(file, {.bytes = std::numeric_limits<std::size_t>::max()});
    text += fmt::format("{} {:016x}\n", file, io::fnv1a(content));
  }
  return text;
}

}  // namespace

bool has_air(const SimulateArguments& arguments) {
  return !arguments.cloud.turbulence.empty() || !arguments.cloud.flow.empty() || !arguments.wind.empty();
}

NamedAir air_of(const SimulateArguments& arguments, const models::ParametricModel& model, std::uint64_t seed,
                double body_radius) {
  const bool has_flow = !arguments.cloud.flow.empty();
  if (has_flow && !(arguments.wind.empty() && arguments.cloud.turbulence.empty()))
    throw ArgumentError("--flow says another fluid than --wind or --turbulence: one of them was expected");
  NamedAir air = has_flow                  ? wake_of(arguments, model, seed, body_radius)
                 : !arguments.wind.empty() ? wind_of(arguments, model, seed, body_radius)
                                           : turbulence_of(arguments, model, seed, body_radius);
  air.identity = identity_of(arguments, air.description, seed, body_radius);
  return air;
}

}  // namespace samara::apps
