#include "samara/motion/bodies/steered_model.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/laws/registry.h"
#include "samara/models/stochastic/gust_layout.h"

namespace samara::motion {

models::ParametricModel steered_model(const MotionDatabase& database, bool in_wind) {
  if (!in_wind) return database.parametric_model();
  const std::string name = database.model + "_in_gusts";
  const auto& known = models::model_names();
  if (std::ranges::find(known, name) == known.end())
    throw ArgumentError(fmt::format("there is no model \"{}\": bodies of \"{}\" fall in still air only", name,
                                    database.model));
  std::vector<std::string> free = database.coefficient_names;
  const auto model = models::find_model(name);
  const std::vector<std::string> gusts = models::GustLayout(*model).parameter_names();
  free.insert(free.end(), gusts.begin(), gusts.end());
  return {model, database.fixed, free};
}

}  // namespace samara::motion
