#include "samara/identification/trajectories/coordinate_names.h"

#include <algorithm>

namespace samara::identification {

bool contains(std::span<const std::string> names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

std::vector<std::string> names_of(std::span<const FitCoordinate> coordinates) {
  std::vector<std::string> names;
  for (const FitCoordinate& c : coordinates) names.push_back(c.name);
  return names;
}

std::optional<std::size_t> position(std::span<const FitCoordinate> coordinates, const std::string& name) {
  const auto found = std::ranges::find(coordinates, name, &FitCoordinate::name);
  if (found == coordinates.end()) return {};
  return static_cast<std::size_t>(found - coordinates.begin());
}

}  // namespace samara::identification
