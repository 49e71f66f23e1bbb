#include "winds.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/model/wind_file.h"
#include "samara/models/laws/ambient_flow.h"
#include "samara/models/stochastic/gust_layout.h"

namespace samara::apps {

BodyOutline outline_of(const models::ParametricModel& model, std::optional<double> radius) {
  const models::ModelInfo& info = model.model().info();
  model.check({});
  const std::vector<double> all = model.parameters({});
  const auto value_of = [&](const char* name) {
    const auto at = std::ranges::find(info.parameters, name, &models::ParameterInfo::name);
    return at == info.parameters.end() ? 0.0 : all[static_cast<std::size_t>(at - info.parameters.begin())];
  };
  const Eigen::Vector2d semi_axes(value_of("a"), value_of("b"));
  // A plate or a ball: the shortest wave has its length, and no other mean is taken.
  const double own_radius =
      semi_axes.minCoeff() > 0.0 ? semi_axes.maxCoeff() : models::outline_radius(info, all);
  if (!(own_radius > 0.0)) {
    throw ArgumentError(
        fmt::format("--wind: model \"{}\" has no parameters that say the size of its body", info.name));
  }
  if (!radius) return {.length = 2.0 * own_radius, .semi_axes = semi_axes};
  if (!(*radius >= 0.0))
    throw ArgumentError(fmt::format("--body-radius is {:.6g} m, expected 0 or more", *radius));
  return {.length = 2.0 * own_radius, .semi_axes = Eigen::Vector2d::Constant(*radius)};
}

std::shared_ptr<const models::Model> model_in_wind(const std::string& file, std::uint64_t seed,
                                                   const std::shared_ptr<const models::Model>& model,
                                                   const std::map<std::string, double>& values) {
  const std::string& name = model->info().name;
  if (name != "immersed_body" && name != "immersed_body_in_gusts") {
    throw ArgumentError(fmt::format(
        "--wind is for the model \"immersed_body\", or with --realisations for those in gusts; not "
        "for \"{}\"",
        name));
  }
  const BodyOutline body = outline_of(models::ParametricModel(model, values, {}), {});
  const codebooks::WindFile wind = codebooks::read_wind(file);
  if (wind.seen)
    throw InputError(
        file, "has turbulence of the kind \"seen\", which is along paths: --realisations was expected");
  return models::immersed_body_in(models::wind::wind_flow(wind.wind, body.length, seed, 0));
}

}  // namespace samara::apps
