#include "samara/models/model.h"

#include <algorithm>

namespace samara::models {

double state_scale(const StateInfo& state, const Scales& scales) {
  if (state.unit == "m") return scales.length;
  if (state.unit == "m/s") return scales.velocity;
  if (state.unit == "rad/s" || state.unit == "1/s") return 1.0 / scales.time;
  return 1.0;
}

bool in_meaning(const ParameterInfo& parameter, double value) {
  return parameter.lower_inclusive ? value >= parameter.lower : value > parameter.lower;
}

std::string time_unit(const ModelInfo& info) {
  const auto dimensionless = [](const auto& item) { return item.unit == "1"; };
  const bool all = std::all_of(info.states.begin(), info.states.end(), dimensionless) &&
                   std::all_of(info.parameters.begin(), info.parameters.end(), dimensionless);
  return all ? "1" : "s";
}

}  // namespace samara::models
