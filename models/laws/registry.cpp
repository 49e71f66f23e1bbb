#include "samara/models/laws/registry.h"

#include <algorithm>
#include <mutex>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/models/fields/field_model.h"

// The models that ship with Samara, one line each: laws/<name>.cpp or wakes/<name>.cpp defines the function <name>(),
// as law_model.h says; plate, coefficient_body and kirchhoff_body in gusts stand beside these.
#define SAMARA_LAWS(LAW)         \
  LAW(coefficient_body)          \
  LAW(coefficient_body_in_gusts) \
  LAW(constant_rate)             \
  LAW(coupled_triple)            \
  LAW(falling_plate)             \
  LAW(falling_plate_in_gusts)    \
  LAW(falling_plate_linear_drag) \
  LAW(falling_plate_nd)          \
  LAW(falling_plate_with_wake)   \
  LAW(falling_rectangle)         \
  LAW(immersed_body)             \
  LAW(immersed_body_in_gusts)    \
  LAW(immersed_body_in_wind)     \
  LAW(immersed_body_with_wake)   \
  LAW(kirchhoff_body)            \
  LAW(kirchhoff_body_in_gusts)   \
  LAW(quadratic_drag_fall)       \
  LAW(sphere_flight)             \
  LAW(sphere_flight_in_gusts)    \
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

/// Models are added rarely, and looked up by several threads.
class Registry {
 public:
  ModelList all() const {
    const std::scoped_lock lock(mutex_);
    return models_;
  }
  /// @returns false if there is another of its name
  bool add(const std::shared_ptr<const Model>& model) {
    const std::scoped_lock lock(mutex_);
    const auto place = std::ranges::lower_bound(models_, model->info().name, {}, name_of);
    if (place != models_.end() && name_of(*place) == model->info().name) return *place == model;
    models_.insert(place, model);
    return true;
  }

 private:
  static const std::string& name_of(const std::shared_ptr<const Model>& model) { return model->info().name; }

  mutable std::mutex mutex_;
  ModelList models_ = make_models();
};

Registry& registry() {
  static Registry models;
  return models;
}

}  // namespace

std::vector<std::string> model_names() {
  std::vector<std::string> names;
  for (const auto& model : registry().all()) names.push_back(model->info().name);
  return names;
}

std::shared_ptr<const Model> find_model_or_null(const std::string& name) {
  for (const auto& model : registry().all()) {
    if (model->info().name == name) return model;
  }
  return nullptr;
}

std::shared_ptr<const Model> find_model(const std::string& name) {
  if (auto model = find_model_or_null(name)) return model;
  throw ArgumentError("there is no model \"" + name + "\"" + suggestion(name, model_names()));
}

void add_model(const std::shared_ptr<const Model>& model) {
  if (!model) throw ArgumentError("a null pointer was given, a model was expected");
  if (find_field_model(model->info().name) != nullptr || !registry().add(model))
    throw ArgumentError("there is another model \"" + model->info().name + "\" already");
}

}  // namespace samara::models
