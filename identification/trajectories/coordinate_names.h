#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "samara/identification/trajectories/trajectory_source.h"

/// Internal to identification/.
namespace samara::identification {

bool contains(std::span<const std::string> names, const std::string& name);

std::vector<std::string> names_of(std::span<const FitCoordinate> coordinates);

/// Where the coordinate of that name stands.
std::optional<std::size_t> position(std::span<const FitCoordinate> coordinates, const std::string& name);

}  // namespace samara::identification
