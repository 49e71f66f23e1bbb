#pragma once

#include <span>
#include <string>

#include "samara/identification/trajectories/trajectory_source.h"

/// Internal to identification/.
namespace samara::identification {

bool contains(std::span<const std::string> names, const std::string& name);

}  // namespace samara::identification
