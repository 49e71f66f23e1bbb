#include "samara/models/wind/body_outline.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/stochastic/gust_layout.h"

namespace samara::models::wind {

BodyOutline outline_of(const ParametricModel& model, std::optional<double> radius) {
  const ModelInfo& info = model.model().info();
  model.check({});
  const std::vector<double> all = model.parameters({});
  const auto value_of = [&](const char* name) {
    const auto at = std::ranges::find(info.parameters, name, &ParameterInfo::name);
    return at == info.parameters.end() ? 0.0 : all[static_cast<std::size_t>(at - info.parameters.begin())];
  };
  const Eigen::Vector2d semi_axes(value_of("a"), value_of("b"));
  // A plate or a ball: the shortest wave has its length, and no other mean is taken.
  const double own_radius = semi_axes.minCoeff() > 0.0 ? semi_axes.maxCoeff() : outline_radius(info, all);
  if (!(own_radius > 0.0)) {
    throw ArgumentError(fmt::format(
        "model \"{}\" has no parameters that say the size of its body, which a wind asks for", info.name));
  }
  if (!radius) return {.length = 2.0 * own_radius, .semi_axes = semi_axes};
  require_not_negative(*radius, "radius of the body [m]");
  if (*radius > 0.0 && !(semi_axes.minCoeff() > 0.0)) {
    throw ArgumentError(
        fmt::format("the radius of the body is {:.6g} m, but that of model \"{}\" is no flat one with "
                    "semi-axes a and b, over whose "
                    "outline a wind is averaged; none or 0 was expected",
                    *radius, info.name));
  }
  return {.length = 2.0 * own_radius, .semi_axes = Eigen::Vector2d::Constant(*radius)};
}

}  // namespace samara::models::wind
