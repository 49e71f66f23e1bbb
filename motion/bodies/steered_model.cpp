#include "samara/motion/bodies/steered_model.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/laws/registry.h"

namespace samara::motion {

namespace {

/// Parameters by which a model is told of the air along the path of its body, in their order.
constexpr std::array kGusts = {"gust_start",      "gust_x",          "gust_y",      "gust_z",
                               "gust_rate_x",     "gust_rate_y",     "gust_rate_z", "gust_material_x",
                               "gust_material_y", "gust_material_z", "gust_spin_x", "gust_spin_y",
                               "gust_spin_z"};

}  // namespace

models::ParametricModel steered_model(const MotionDatabase& database, bool in_wind) {
  if (!in_wind) return database.parametric_model();
  if (database.moving_states().is_planar())
    throw ArgumentError(
        fmt::format("\"{}\" moves in a plane: its bodies fall in still air only", database.model));
  const std::string name = database.model + "_in_gusts";
  const auto& known = models::model_names();
  if (std::ranges::find(known, name) == known.end())
    throw ArgumentError(fmt::format("there is no model \"{}\": bodies of \"{}\" fall in still air only", name,
                                    database.model));
  std::vector<std::string> free = database.coefficient_names;
  free.insert(free.end(), kGusts.begin(), kGusts.end());
  return {models::find_model(name), database.fixed, free};
}

}  // namespace samara::motion
