#include "samara/identification/trajectories/coordinate_names.h"

#include <algorithm>

namespace samara::identification {

bool contains(std::span<const std::string> names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

}  // namespace samara::identification
