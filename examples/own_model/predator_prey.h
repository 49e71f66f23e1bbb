// Predators and their prey, by A. J. Lotka (1925) and V. Volterra (1926), as a law of your own.
#pragma once

#include "samara/models/laws/law_model.h"

struct PredatorPrey {
  static constexpr int kStates = 2, kParameters = 4;

  static samara::models::ModelInfo info() {
    return {
        .name = "predator_prey_law",
        .title = "Predators and their prey",
        .equations =
            "prey' = growth prey - hunt prey predator,  predator' = gain prey predator - death "
            "predator",
        .frames = "numbers of animals",
        .source =
            "A. J. Lotka, Elements of Physical Biology (1925); V. Volterra, Nature 118 (1926) "
            "558-560",
        .validity = "many animals, well mixed",
        .states = {{.name = "prey",
                    .unit = "1",
                    .default_initial = 10.0,
                    .description = "animals hunted"},
                   {.name = "predator",
                    .unit = "1",
                    .default_initial = 5.0,
                    .description = "animals hunting"}},
        .parameters =
            {{.name = "growth", .unit = "1/s", .description = "of prey left alone", .lower = 0.0},
             {.name = "hunt", .unit = "1/s", .description = "prey lost per predator", .lower = 0.0},
             {.name = "gain", .unit = "1/s", .description = "predators won per prey", .lower = 0.0},
             {.name = "death",
              .unit = "1/s",
              .description = "of predators without prey",
              .lower = 0.0}},
        .affine_in = {"growth", "hunt", "gain", "death"},
    };
  }

  template <class S>
  static void rhs(const S& /*t*/, const S* x, const S* p, S* dxdt) {
    const S meetings = x[0] * x[1];
    dxdt[0] = p[0] * x[0] - p[1] * meetings;
    dxdt[1] = p[2] * meetings - p[3] * x[1];
  }
};
