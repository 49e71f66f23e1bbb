#include "samara/codebooks/statistics/distribution.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <boost/math/special_functions/erf.hpp>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/unit_labels.h"
#include "samara/pgd/axes/axis_transform.h"

namespace samara::codebooks {

namespace {

/// In the order of DistributionKind.
const std::vector<std::string> kKinds = {"uniform", "normal", "lognormal"};

/// Beyond so many deviations nothing is left that counts in doubles.
constexpr double kReach = 9.0;

/// As a standard normal variable. x > 0 of log-normal ones.
double standardised(const Distribution& distribution, double x) {
  if (distribution.kind == DistributionKind::normal) return (x - distribution.first) / distribution.second;
  return std::log(x / distribution.first) / distribution.second;
}

double from_standard(const Distribution& distribution, double z) {
  if (distribution.kind == DistributionKind::normal) return distribution.first + distribution.second * z;
  return distribution.first * std::exp(distribution.second * z);
}

/// Up to a factor.
double density(const Distribution& distribution, double x) {
  if (distribution.kind == DistributionKind::uniform) return 1.0;
  if (distribution.kind == DistributionKind::log_normal && !(x > 0.0)) return 0.0;
  const double z = standardised(distribution, x);
  const double bell = std::exp(-0.5 * z * z);
  return distribution.kind == DistributionKind::normal ? bell : bell / x;
}

/// Where the rule begins anew: borders of elements, and whole numbers of deviations.
std::vector<double> panel_borders(const Distribution& distribution, const pgd::Axis& axis) {
  double lower = axis.lower(), upper = axis.upper();
  std::vector<double> borders;
  if (distribution.kind == DistributionKind::uniform) {
    lower = std::max(lower, distribution.first);
    upper = std::min(upper, distribution.second);
  } else {
    // A log-normal one is a bell in the logarithm: where that is wide, in more parts.
    const double wide =
        distribution.kind == DistributionKind::log_normal ? std::max(1.0, distribution.second) : 1.0;
    const double step = 1.0 / std::ceil(2.0 * wide);
    for (double z = -kReach; z <= kReach; z += step) borders.push_back(from_standard(distribution, z));
    lower = std::max(lower, borders.front());
    upper = std::min(upper, borders.back());
  }
  if (!(lower < upper)) return {};
  borders.insert(borders.end(), axis.borders().begin(), axis.borders().end());
  // The slope of a transform, and functions of a period, are no polynomials: many short panels, under a transform equal
  // ones in what is transformed.
  const int panels = std::max(32, 2 * axis.size());
  if (axis.transform() != pgd::Transform::none) {
    const double whole = pgd::transformed_distance(axis.transform(), lower, upper);
    for (int k = 1; k < panels; ++k)
      borders.push_back(pgd::transformed_advance(axis.transform(), lower, whole * k / panels));
  } else if (!axis.has_elements()) {
    for (int k = 1; k < panels; ++k) borders.push_back(lower + (upper - lower) * k / panels);
  }
  std::erase_if(borders, [&](double x) { return !(x > lower && x < upper); });
  borders.push_back(lower);
  borders.push_back(upper);
  std::sort(borders.begin(), borders.end());
  borders.erase(std::unique(borders.begin(), borders.end()), borders.end());
  return borders;
}

}  // namespace

DistributionKind distribution_from_string(const std::string& name) {
  const auto found = std::ranges::find(kKinds, name);
  if (found == kKinds.end())
    throw ArgumentError(fmt::format("unknown distribution \"{}\"{}", name, suggestion(name, kKinds)));
  return static_cast<DistributionKind>(found - kKinds.begin());
}

std::string to_string(const Distribution& distribution) {
  return fmt::format("{}({}, {})", kKinds[static_cast<std::size_t>(distribution.kind)], distribution.first,
                     distribution.second);
}

void require_distribution(const std::string& what, const Distribution& distribution) {
  const auto [kind, first, second] = distribution;
  const auto refuse = [&](const char* expected) {
    throw ArgumentError(
        fmt::format("the distribution of {} is {}, expected {}", what, to_string(distribution), expected));
  };
  if (!std::isfinite(first) || !std::isfinite(second)) refuse("finite numbers");
  if (kind == DistributionKind::uniform) {
    if (!(first < second)) refuse("a least value below the largest");
    return;
  }
  if (!(second > 0.0)) refuse("a deviation above 0");
  if (kind != DistributionKind::log_normal) return;
  if (!(first > 0.0)) refuse("a median above 0");
  // Over nine such deviations a value leaves what doubles hold, and the rule takes panels for each of them.
  constexpr double kWidest = 100.0;
  if (second > kWidest) refuse("a deviation of the logarithm of at most 100");
}

void require_no_list(const pgd::Axis& axis) {
  if (!axis.is_list()) return;
  throw ArgumentError(fmt::format(
      "\"{}\" is a list of values, which has no distribution; it can be set to one of them", axis.name()));
}

double probability_below(const Distribution& distribution, double x) {
  if (distribution.kind == DistributionKind::uniform)
    return std::clamp((x - distribution.first) / (distribution.second - distribution.first), 0.0, 1.0);
  if (distribution.kind == DistributionKind::log_normal && !(x > 0.0)) return 0.0;
  return 0.5 * std::erfc(-standardised(distribution, x) / std::numbers::sqrt2);
}

double quantile_of(const Distribution& distribution, double share) {
  if (distribution.kind == DistributionKind::uniform)
    return distribution.first + share * (distribution.second - distribution.first);
  return from_standard(distribution, -std::numbers::sqrt2 * boost::math::erfc_inv(2.0 * share));
}

pgd::QuadratureRule rule_of(const Distribution& distribution, const pgd::Axis& axis) {
  require_distribution("\"" + axis.name() + "\"", distribution);
  require_no_list(axis);
  const std::vector<double> borders = panel_borders(distribution, axis);
  // Products of two functions of an element, and a bell over one deviation.
  constexpr int kOfTheBell = 14;
  const pgd::QuadratureRule panel =
      pgd::gauss_legendre(kOfTheBell + (axis.has_elements() ? axis.degree() : 2));
  const Eigen::Index points = panel.nodes.size();
  const auto panels = static_cast<Eigen::Index>(std::max<std::size_t>(borders.size(), 1)) - 1;
  pgd::QuadratureRule rule{Eigen::VectorXd(panels * points), Eigen::VectorXd(panels * points)};
  for (Eigen::Index k = 0; k < panels; ++k) {
    const double from = borders[static_cast<std::size_t>(k)], to = borders[static_cast<std::size_t>(k) + 1];
    // Over what is transformed, in which functions of the axis are polynomials.
    const pgd::Transform transform = axis.transform();
    const double length = pgd::transformed_distance(transform, from, to);
    for (Eigen::Index i = 0; i < points; ++i) {
      const double x = pgd::transformed_advance(transform, from, 0.5 * length * (1.0 + panel.nodes[i]));
      rule.nodes[k * points + i] = std::clamp(x, axis.lower(), axis.upper());
      rule.weights[k * points + i] =
          0.5 * length * panel.weights[i] * density(distribution, x) / pgd::transform_slope(transform, x);
    }
  }
  const double sum = rule.weights.sum();
  if (!(sum > 0.0)) {
    const double least = 1e-9 * std::max(std::abs(distribution.first), axis.length());
    if (distribution.kind == DistributionKind::normal && distribution.second < least)
      throw ArgumentError(fmt::format("the deviation of {} of \"{}\" is below rounding; a value was expected",
                                      to_string(distribution), axis.name()));
    throw ArgumentError(fmt::format(
        "none of the distribution {} lies within \"{}\", which goes from {} to {}{}", to_string(distribution),
        axis.name(), axis.lower(), axis.upper(), unit_suffix(axis.unit())));
  }
  rule.weights /= sum;
  return rule;
}

}  // namespace samara::codebooks
