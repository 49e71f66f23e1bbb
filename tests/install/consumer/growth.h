// A law of a user's own, against the installed headers.
#pragma once

#include <samara/models/laws/law_model.h>

struct Growth {
  static constexpr int kStates = 1, kParameters = 1;
  static samara::models::ModelInfo info() {
    return {.name = "growth",
            .title = "What grows by itself",
            .equations = "x' = rate x",
            .frames = "a number",
            .source = "T. R. Malthus, An Essay on the Principle of Population (1798)",
            .validity = "as long as nothing is short",
            .states = {{.name = "x", .unit = "1", .default_initial = 1.0, .description = "how many"}},
            .parameters = {{.name = "rate", .unit = "1/s", .description = "births less deaths"}}};
  }
  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    dxdt[0] = p[0] * x[0];
  }
};
