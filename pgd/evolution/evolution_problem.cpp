#include "samara/pgd/evolution/evolution_problem.h"

#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/evolution/evolution_checks.h"
#include "samara/pgd/evolution/polynomial_system.h"

namespace samara::pgd {

void check_states(const EvolutionSystem* system, const std::vector<OutputLabel>& states,
                  const std::vector<double>& scales, const std::vector<InitialValue>& initial,
                  std::size_t parameters) {
  if (system == nullptr) throw ArgumentError("the evolution problem has no system");
  const auto n = static_cast<std::size_t>(system->state_count());
  if (n == 0 || states.size() != n || scales.size() != n || initial.size() != n) {
    throw ArgumentError(
        fmt::format("the system has {} states; {} labels, {} scales and {} initial values were given", n,
                    states.size(), scales.size(), initial.size()));
  }
  const PolynomialSystem* polynomial = system->polynomial();
  if (polynomial != nullptr && static_cast<std::size_t>(polynomial->parameter_count()) != parameters) {
    throw ArgumentError(fmt::format("the polynomial system has {} parameters, the problem {} axes",
                                    polynomial->parameter_count(), parameters));
  }
  if (polynomial != nullptr && static_cast<std::size_t>(polynomial->state_count()) != n) {
    throw ArgumentError(fmt::format("the polynomial system has {} states, the system itself {}",
                                    polynomial->state_count(), n));
  }
  for (std::size_t s = 0; s < n; ++s) {
    if (!(scales[s] > 0.0) || !std::isfinite(scales[s])) {
      throw ArgumentError(
          fmt::format("the scale of {} is {}, expected a positive number", states[s].name, scales[s]));
    }
    if (initial[s].axis >= static_cast<int>(parameters) || !std::isfinite(initial[s].value)) {
      throw ArgumentError(
          fmt::format("the initial value of {} is {} or axis {} of {}, expected a finite number or an axis",
                      states[s].name, initial[s].value, initial[s].axis, parameters));
    }
  }
}

void EvolutionProblem::validate() const {
  check_states(system, states, scales, initial, parameters.size());
  if (!time.has_elements() || time.transform() != Transform::none) {
    throw ArgumentError(
        fmt::format("the time axis \"{}\" is {} with the transform \"{}\", expected elements and \"none\"",
                    time.name(), to_string(time.basis()), to_string(time.transform())));
  }
}

}  // namespace samara::pgd
