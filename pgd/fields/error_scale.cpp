#include "samara/pgd/fields/error_scale.h"

#include <algorithm>
#include <cmath>

namespace samara::pgd {

double error_scale(const OutputSpread& output) {
  constexpr double kRounding = 1e-12;
  const double range = std::max(output.range, output.floor);
  if (range > kRounding * output.size) return range;
  return output.size > 0.0 ? output.size : 1.0;
}

Eigen::VectorXd error_scales(const Eigen::VectorXd& smallest, const Eigen::VectorXd& largest,
                             const OutputMeasure& measure) {
  Eigen::VectorXd scales(smallest.size());
  for (Eigen::Index o = 0; o < scales.size(); ++o) {
    OutputSpread output{.range = largest[o] - smallest[o],
                        .size = std::max(std::abs(smallest[o]), std::abs(largest[o]))};
    if (measure.floors.size() > 0) output.floor = measure.floors[o];
    if (measure.sizes.size() > 0) output.size = std::max(output.size, measure.sizes[o]);
    scales[o] = error_scale(output);
  }
  return scales;
}

}  // namespace samara::pgd
