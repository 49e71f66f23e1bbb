#include "samara/pgd/evolution/adaptive_problem.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/evolution/evolution_checks.h"

namespace samara::pgd {

namespace {

void check_axis(const AdaptiveAxis& axis) {
  const BasisTraits& basis = basis_traits(axis.basis);
  if (basis.discretises_parameters() && (basis.tells_resolution || axis.nodes)) return;
  throw ArgumentError(
      fmt::format("axis \"{}\" is {}, expected chebyshev, legendre, fourier, or p1 or p2 with "
                  "a number of nodes",
                  axis.label.name, to_string(axis.basis)));
}

}  // namespace

Axis make_axis(const AdaptiveAxis& axis, int nodes) {
  const BasisTraits& basis = basis_traits(axis.basis);
  const int count = basis.odd_nodes ? nodes / 2 * 2 + 1 : nodes;
  return basis.over_interval(axis.label, axis.lower, axis.upper, count);
}

Eigen::VectorXd start_sizes(const AdaptiveProblem& problem) {
  Eigen::VectorXd sizes(static_cast<Eigen::Index>(problem.initial.size()));
  for (Eigen::Index s = 0; s < sizes.size(); ++s) {
    const InitialValue& start = problem.initial[static_cast<std::size_t>(s)];
    sizes[s] = std::abs(start.value);
    if (start.axis < 0) continue;
    const AdaptiveAxis& axis = problem.parameters[static_cast<std::size_t>(start.axis)];
    sizes[s] = std::max(std::abs(axis.lower), std::abs(axis.upper));
  }
  return sizes;
}

void check_problem(const AdaptiveProblem& problem) {
  check_states(problem.system, problem.states, problem.scales, problem.initial, problem.parameters.size());
  if (problem.scale_floors.size() != problem.states.size()) {
    throw ArgumentError(
        fmt::format("{} scale floors for {} states", problem.scale_floors.size(), problem.states.size()));
  }
  for (const double floor : problem.scale_floors) {
    if (!(floor >= 0.0) || !std::isfinite(floor))
      throw ArgumentError(fmt::format("a scale floor is {}, expected a finite number of at least 0", floor));
  }
  for (const AdaptiveAxis& axis : problem.parameters) check_axis(axis);
}

}  // namespace samara::pgd
