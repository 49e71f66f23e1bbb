#include "samara/models/laws/registry.h"

#include <algorithm>

#include "samara/base/errors.h"
#include "samara/base/names.h"

// The models that ship with Samara, one line each: laws/<name>.cpp defines the function <name>().
#define SAMARA_LAWS(LAW)         \
  LAW(coefficient_body)          \
  LAW(constant_rate)             \
  LAW(coupled_triple)            \
  LAW(falling_plate)             \
  LAW(falling_plate_linear_drag) \
  LAW(falling_plate_nd)          \
  LAW(falling_rectangle)         \
  LAW(immersed_body)             \
  LAW(immersed_body_in_wind)     \
  LAW(kirchhoff_body)            \
  LAW(quadratic_drag_fall)       \
  LAW(sphere_flight)             \
  LAW(sphere_flight_turned_spin) \
  LAW(vertical_fall)

namespace samara::models {

namespace laws {
#define SAMARA_DECLARE(name) std::shared_ptr<const Model> name();
SAMARA_LAWS(SAMARA_DECLARE)
#undef SAMARA_DECLARE
}  // namespace laws

namespace {

using ModelList = std::vector<std::shared_ptr<const Model>>;

ModelList make_models() {
#define SAMARA_CALL(name) laws::name(),
  ModelList models = {SAMARA_LAWS(SAMARA_CALL)};
#undef SAMARA_CALL
  std::ranges::sort(models, {}, [](const auto& model) -> const std::string& { return model->info().name; });
  return models;
}

const ModelList& all_models() {
  static const ModelList models = make_models();
  return models;
}

}  // namespace

std::vector<std::string> model_names() {
  std::vector<std::string> names;
  for (const auto& model : all_models()) names.push_back(model->info().name);
  return names;
}

std::shared_ptr<const Model> find_model(const std::string& name) {
  for (const auto& model : all_models()) {
    if (model->info().name == name) return model;
  }
  throw ArgumentError("there is no model \"" + name + "\"" + suggestion(name, model_names()));
}

}  // namespace samara::models
