#include "samara/identification/problem/box_bounds.h"

#include <algorithm>
#include <cmath>

namespace samara::identification {

namespace {

/// Within a ten millionth of the box, and of the numbers themselves: boxes may span many decades.
bool is_at(double value, double bound, double width) {
  return std::abs(value - bound) <= 1e-7 * std::min(width, std::max(std::abs(value), std::abs(bound)));
}

}  // namespace

std::vector<char> at_bounds(const std::vector<models::FamilyCoordinate>& coordinates, const Chart& chart,
                            const Eigen::Ref<const Eigen::VectorXd>& values) {
  std::vector<char> at(static_cast<std::size_t>(values.size()), 0);
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    if (chart.is_part_of_quaternion(static_cast<int>(k))) continue;
    const models::FamilyCoordinate& c = coordinates[k];
    const double value = values[static_cast<Eigen::Index>(k)];
    const double width = c.upper - c.lower;
    at[k] = is_at(value, c.lower, width) || is_at(value, c.upper, width);
  }
  return at;
}

}  // namespace samara::identification
