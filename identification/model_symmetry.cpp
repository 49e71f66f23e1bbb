#include "samara/identification/model_symmetry.h"

#include <algorithm>

namespace samara::identification {

std::vector<std::string> translated_outputs(const models::ModelInfo& model,
                                            const std::vector<FitOutput>& outputs) {
  std::vector<std::string> translated;
  for (const FitOutput& output : outputs) {
    if (std::ranges::count(model.symmetries, "translation of " + output.name) > 0)
      translated.push_back(output.name);
  }
  return translated;
}

std::vector<std::string> attitude_outputs(const models::ModelInfo& model,
                                          const std::vector<FitOutput>& outputs) {
  for (const models::StateGroup& group : model.groups) {
    if (group.kind != models::StateGroupKind::quaternion) continue;
    std::vector<std::string> names;
    for (int part = 0; part < 4; ++part) {
      names.push_back(model.states[static_cast<std::size_t>(group.first + part)].name);
      if (std::ranges::count(outputs, names.back(), &FitOutput::name) == 0) return {};
    }
    return names;
  }
  return {};
}

}  // namespace samara::identification
