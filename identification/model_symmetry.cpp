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

}  // namespace samara::identification
