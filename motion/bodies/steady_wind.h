#pragma once

#include <memory>

#include "samara/models/laws/ambient_flow.h"

namespace samara::motion {

/// Air that moves everywhere alike.
/// @param velocity world, z up, m/s. @throws ArgumentError unless it is finite
std::shared_ptr<const models::AmbientFlow> steady_wind(const Eigen::Vector3d& velocity);

}  // namespace samara::motion
