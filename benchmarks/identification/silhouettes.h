#pragma once

#include <memory>

#include "samara/models/trajectories/trajectory_family.h"

namespace samara::benchmarks::identification {

/// A family of discs with what two level cameras see of them: outputs "silhouette_1" and "silhouette_2"
/// [px^2],
///
///   size_c a^2 sqrt((n . d_c)^2 + 0.05^2),   d_c = (cos view_c, sin view_c, 0),
///
/// n the normal; with the shared coordinates size_1, size_2 (pi px^2 a square metre) and view_1, view_2
/// (rad).
/// @param bodies a family with the coordinate "a" and the attitude of immersed_body among its outputs
std::unique_ptr<samara::models::TrajectoryFamily> with_silhouettes(
    std::unique_ptr<samara::models::TrajectoryFamily> bodies);

}  // namespace samara::benchmarks::identification
