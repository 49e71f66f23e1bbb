#include "samara/identification/problem/fit_result.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "samara/base/rounded.h"
#include "samara/identification/statistics/cluster_errors.h"
#include "samara/identification/statistics/quantiles.h"

namespace samara::identification {

double NoiseLevel::standard_error() const {
  return value / std::sqrt(2.0 * degrees_of_freedom);
}

const Profile* FitResult::find_profile(const std::string& coefficient) const {
  const auto found = std::ranges::find(profiles, coefficient, &Profile::name);
  return found == profiles.end() ? nullptr : &*found;
}

namespace {

/// Student's quantile at 97.5 % over the normal one.
double student_factor(double degrees_of_freedom) {
  constexpr double kUpper = 0.975;
  return student_quantile(degrees_of_freedom, kUpper) / normal_quantile(kUpper);
}

double widening(const FitResult& result, const Coefficient& c) {
  if (!c.standard_error) return 1.0;
  const double clusters = c.effective_clusters.value_or(result.clusters);
  return student_factor(error_degrees(clusters, result.clusters));
}

/// What is known if the fit stands in its minimum, and there is one only.
std::string plain_verdict(const FitResult& result, const Coefficient& c) {
  const std::string bound = c.at_bound ? "at a bound of its box" : "";
  if (const Profile* profile = result.find_profile(c.name))
    return fmt::format("{}{}{}", bound, bound.empty() ? "" : ", ", describe(*profile));
  if (c.at_bound) return bound;
  const std::optional<double> error = widened_error(result, c);
  if (!error) return "of unknown error";
  // The deviation of a uniform distribution over the box: the data say no more than the box did.
  const double of_box = (c.upper - c.lower) / std::sqrt(12.0);
  if (*error >= of_box) return fmt::format("hardly determined: +- {:.2g}", *error);
  return with_error(c.value, error);
}

/// " or 0.87 +- 0.08" for each optimum that is as good, where the value is another one.
std::string other_values(const FitResult& result, const Coefficient& c) {
  const auto at = static_cast<std::size_t>(&c - result.coefficients.data());
  std::string text;
  for (const OtherOptimum& optimum : result.other_optima) {
    const double value = optimum.coefficients[at];
    const double error = optimum.standard_errors[at] * widening(result, c);
    if (std::abs(value - c.value) <= 0.5 * widened_error(result, c).value_or(0.0)) continue;
    text += " or " + with_error(value, error);
  }
  return text;
}

}  // namespace

std::optional<double> widened_error(const FitResult& result, const Coefficient& coefficient) {
  if (!coefficient.standard_error) return coefficient.naive_standard_error;
  double error = *coefficient.standard_error;
  if (result.bootstrap) {
    const auto at = static_cast<std::size_t>(&coefficient - result.coefficients.data());
    const double bent = result.bootstrap->standard_errors[at];
    if (bent > error) error = bent;  // never where it is NaN
  }
  return widening(result, coefficient) * error;
}

std::vector<int> carriers(const FitResult& result, const Coefficient& coefficient) {
  std::vector<int> few;
  if (result.clusters <= 2 || !(coefficient.effective_clusters.value_or(kFewClusters) < kFewClusters))
    return few;
  const auto& shares = coefficient.cluster_shares;
  for (int c = 0; c < static_cast<int>(shares.size()); ++c) few.push_back(c);
  std::ranges::sort(few, std::greater(), [&](int c) { return shares[static_cast<std::size_t>(c)]; });
  // One carries it if it says more than three times as much as the next.
  const auto share = [&](std::size_t k) { return shares[static_cast<std::size_t>(few[k])]; };
  few.resize(share(0) > 3.0 * share(1) ? 1 : 2);
  return few;
}

bool Posterior::is_settled() const {
  return divergences == 0 && std::ranges::all_of(unknowns, [](const PosteriorUnknown& u) {
           return u.rhat <= 1.01 && u.effective >= 400.0;
         });
}

std::string verdict(const FitResult& result, const Coefficient& coefficient) {
  // First: limits of a profile would only be those that the boxes of the others leave.
  if (!coefficient.determined) return "not determined";
  if (result.status == Termination::max_iterations)
    return fmt::format("not converged, stopped at {:.5g}", coefficient.value);
  std::string text = plain_verdict(result, coefficient) + other_values(result, coefficient);
  std::vector<std::string> names;
  for (const int c : carriers(result, coefficient))
    names.push_back(result.cluster_names[static_cast<std::size_t>(c)]);
  if (!names.empty()) text += fmt::format(", by {} almost alone", fmt::join(names, " and "));
  return text;
}

}  // namespace samara::identification
