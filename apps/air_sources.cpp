#include "air_sources.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "assignments.h"
#include "samara/base/errors.h"
#include "samara/models/stochastic/fluid_seen.h"

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

}  // namespace

bool has_air(const SimulateArguments& arguments) {
  return !arguments.cloud.turbulence.empty();
}

NamedAir air_of(const SimulateArguments& arguments, const models::ParametricModel& model, std::uint64_t seed,
                double body_radius) {
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
  models::SeenOptions seen = {.radius = body_radius, .rotation = arguments.cloud.rotation};
  // Of the fluid that the body is in; that of air where a model does not say.
  const std::vector<models::ParameterInfo>& parameters = model.model().info().parameters;
  const auto nu = std::ranges::find(parameters, "nu", &models::ParameterInfo::name);
  if (nu != parameters.end())
    seen.viscosity = model.parameters({})[static_cast<std::size_t>(nu - parameters.begin())];
  if (!arguments.cloud.C_0.empty()) {
    seen.C_0 = number_or_quantity("--C0", arguments.cloud.C_0, "1");
    if (!(seen.C_0 > 0.0))
      throw ArgumentError(fmt::format("--C0 is {}, expected more than 0", arguments.cloud.C_0));
  }
  const auto flow = words.decays ? models::decaying_turbulence(k, epsilon, stream)
                                 : models::uniform_turbulence(k, epsilon, stream);
  return {
      models::fluid_seen_in(flow, seed, seen),
      fmt::format(
          "{} turbulence, k = {:.6g} m^2/s^2, epsilon = {:.6g} m^2/s^3, stream ({:.6g}, {:.6g}, {:.6g}) m/s",
          words.decays ? "decaying" : "uniform", k, epsilon, stream.x(), stream.y(), stream.z())};
}

}  // namespace samara::apps
