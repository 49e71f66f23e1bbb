#include "samara/identification/problem/priors.h"

#include <cmath>

#include <fmt/format.h>

#include "samara/base/require.h"

namespace samara::identification {

double standard_deviation(const Prior& prior) {
  return prior.logarithmic ? prior.mean * prior.deviation : prior.deviation;
}

void validate(const PriorOptions& priors) {
  for (const auto& [name, prior] : priors.coordinates) {
    require_positive(prior.deviation, fmt::format("the deviation of the prior of \"{}\"", name));
    if (prior.logarithmic) require_positive(prior.mean, fmt::format("the mean of the prior of \"{}\"", name));
    require(std::isfinite(prior.mean), fmt::format("the mean of the prior of \"{}\"", name), prior.mean,
            "a finite number");
  }
  for (const CombinationPrior& prior : priors.combinations)
    require_positive(prior.deviation, "the deviation of a combination");
}

}  // namespace samara::identification
