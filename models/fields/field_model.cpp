#include "samara/models/fields/field_model.h"

namespace samara::models {

std::vector<std::string> field_model_names() {
  return {heat_rod().info.name};
}

const FieldModel* find_field_model(const std::string& name) {
  return name == heat_rod().info.name ? &heat_rod() : nullptr;
}

}  // namespace samara::models
