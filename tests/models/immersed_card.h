#pragma once

#include "bodies_in_flow.h"

/// The card of the check values, and what tests ask of it.

using Values = std::map<std::string, double>;

/// The card of the check values: 7 cm x 4 cm x 0.2 mm, semi-axes halves of that.
inline Values card() {
  return {{"a", 0.035},    {"b", 0.02},           {"c", 1e-4},          {"density", 1200.0},
          {"C_D90", 0.61}, {"C_D0", 0.05},        {"C_T", 1.81},        {"C_R", 1.21},
          {"C_w", 2.0},    {"speed_floor", 1e-9}, {"rate_floor", 1e-9}, {"damping_isotropy", 0.0}};
}

inline Values with(Values values, const Values& more) {
  for (const auto& [name, value] : more) values[name] = value;
  return values;
}

inline std::vector<samara::models::Wrench> forces(const samara::models::Model& model, const BodyState& state,
                                                  const samara::models::ParameterValues& p) {
  std::vector<samara::models::Wrench> terms(model.info().force_terms.size());
  model.forces(0.0, state.vector(), p, terms);
  return terms;
}

enum Term { kInertia, kDrag, kTranslationalLift, kRotationalLift, kDamping, kGravity, kAmbient };

inline BodyState random_state(std::mt19937& random) {
  BodyState state;
  state.position = random_vector(random, 1.0);
  state.q = random_attitude(random);
  state.u = random_vector(random, 1.5);
  state.w = random_vector(random, 30.0);
  return state;
}
