#include "winds.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/model/wind_file.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/laws/ambient_flow.h"

namespace samara::apps {

BodyOutline outline_of(const std::shared_ptr<const models::Model>& model,
                       const std::map<std::string, double>& values) {
  const models::ModelInfo& info = model->info();
  if (info.name != "immersed_body")
    throw ArgumentError(fmt::format("--wind is for the model \"immersed_body\", not for \"{}\"", info.name));
  const models::ParametricModel parametric(model, values, {});
  parametric.check({});
  const std::vector<double> all = model->completed(parametric.parameter_values({}));
  const auto value_of = [&](const char* name) {
    return all[static_cast<std::size_t>(
        std::ranges::find(info.parameters, name, &models::ParameterInfo::name) - info.parameters.begin())];
  };
  const Eigen::Vector2d semi_axes(value_of("a"), value_of("b"));
  return {.length = 2.0 * semi_axes.maxCoeff(), .semi_axes = semi_axes};
}

std::shared_ptr<const models::Model> model_in_wind(const std::string& file, std::uint64_t seed,
                                                   const std::shared_ptr<const models::Model>& model,
                                                   const std::map<std::string, double>& values) {
  const BodyOutline body = outline_of(model, values);
  const codebooks::WindFile wind = codebooks::read_wind(file);
  return models::immersed_body_in(models::wind::wind_flow(wind.wind, body.length, seed, 0));
}

}  // namespace samara::apps
