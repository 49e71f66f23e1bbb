#pragma once

#include <Eigen/Core>

namespace samara::models {

/// @throws ArgumentError, naming the axis, unless all three sizes [m] are positive and finite.
void require_sizes(const Eigen::Vector3d& sizes, const char* what, const char* where);

}  // namespace samara::models
