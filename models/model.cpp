#include "samara/models/model.h"

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

}  // namespace samara::models
