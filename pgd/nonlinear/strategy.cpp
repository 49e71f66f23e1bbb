#include "samara/pgd/nonlinear/strategy.h"

#include <fmt/format.h>

#include "samara/pgd/nonlinear/linear_slab.h"

namespace samara::pgd {

Outcome<TensorTrain> Strategy::solution(const StrategySlab& slab, const LinearSlab& linear,
                                        std::optional<double>, CrossPivots& pivots) {
  return solve(slab, linear, pivots);
}

std::string Strategy::on_divergence(double ratio) const {
  return fmt::format(
      "corrections grow, by {:.3g} from the last one: {} does not contract on a slab of this "
      "length,",
      ratio, name());
}

}  // namespace samara::pgd
