#include "samara/identification/fit_result.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::identification {

double NoiseLevel::standard_error() const {
  return value / std::sqrt(2.0 * degrees_of_freedom);
}

std::string to_string(FitStatus status) {
  switch (status) {
    case FitStatus::converged:
      return "converged";
    case FitStatus::not_determined:
      return "not determined";
    case FitStatus::iteration_limit:
      return "iteration limit";
    case FitStatus::failed:
      return "failed";
  }
  throw ArgumentError("a status of no known kind");
}

const Profile* FitResult::find_profile(const std::string& coefficient) const {
  const auto found = std::ranges::find(profiles, coefficient, &Profile::name);
  return found == profiles.end() ? nullptr : &*found;
}

std::string verdict(const FitResult& result, const Coefficient& coefficient) {
  // First: limits of a profile would only be those that the boxes of the others leave.
  if (!coefficient.determined) return "not determined";
  const std::string bound = coefficient.at_bound ? "at a bound of its box" : "";
  if (const Profile* profile = result.find_profile(coefficient.name))
    return fmt::format("{}{}{}", bound, bound.empty() ? "" : ", ", describe(*profile));
  if (coefficient.at_bound) return bound;
  const std::optional<double> error =
      coefficient.standard_error ? coefficient.standard_error : coefficient.naive_standard_error;
  if (!error) return "of unknown error";
  // The deviation of a uniform distribution over the box: the data say no more than the box did.
  const double of_box = (coefficient.upper - coefficient.lower) / std::sqrt(12.0);
  if (*error >= of_box) return fmt::format("hardly determined: +- {:.2g}", *error);
  return fmt::format("{:.5g} +- {:.2g}", coefficient.value, *error);
}

}  // namespace samara::identification
