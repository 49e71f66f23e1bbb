#pragma once

#include <vector>

#include "samara/models/interface/model.h"

/// Parameters of laws in one line each.
namespace samara::models::laws {

using Parameters = std::vector<ParameterInfo>;

inline ParameterInfo positive(const char* name, const char* unit, const char* description) {
  return {.name = name, .unit = unit, .description = description, .lower = 0.0};
}

inline ParameterInfo not_negative(const char* name, const char* unit, double default_value,
                                  const char* description) {
  return {.name = name,
          .unit = unit,
          .default_value = default_value,
          .description = description,
          .lower = 0.0,
          .lower_inclusive = true};
}

/// A number from 0 to 1.
inline ParameterInfo share(const char* name, double default_value, const char* description) {
  ParameterInfo parameter = not_negative(name, "1", default_value, description);
  parameter.upper = 1.0;
  return parameter;
}

inline ParameterInfo derived(const char* name, const char* unit, const char* formula, const char* description,
                             bool may_vanish) {
  return {.name = name,
          .unit = unit,
          .derived = formula,
          .description = description,
          .lower = 0.0,
          .lower_inclusive = may_vanish};
}

inline ParameterInfo with_default(ParameterInfo parameter, double value) {
  parameter.default_value = value;
  return parameter;
}

inline ParameterInfo any_value(const char* name, const char* unit, double default_value,
                               const char* description) {
  return {.name = name, .unit = unit, .default_value = default_value, .description = description};
}

inline void append(Parameters& list, const Parameters& more) {
  list.insert(list.end(), more.begin(), more.end());
}

}  // namespace samara::models::laws
