#include "samara/identification/solve/held_noise.h"

#include "samara/identification/statistics/loss.h"

namespace samara::identification {

void hold_noise(const FitResult& fitted, FitOptions& options) {
  options.noise = {};
  for (const NoiseLevel& level : fitted.noise) {
    const double scale = efficient_bend(options.loss.kind) * level.value;
    for (const std::string& output : level.outputs) {
      if (output == "attitude") {
        options.loss.attitude_scale = scale;
      } else {
        options.loss.scales[output] = scale;
      }
    }
  }
}

}  // namespace samara::identification
