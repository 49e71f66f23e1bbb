#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "samara/motion/patterns/disc_phase_diagram.h"
#include "samara/motion/patterns/share.h"
#include "samara/motion/sweeps/sweep.h"

/// Phase diagrams with shares in place of one colour: a body that is let go in several ways falls in several.
namespace samara::motion {

/// Per point, the share of its falls, over all releases, that have each pattern: points x kPatterns, rows add up to 1.
/// Of whole points: of a sweep that has only begun, those that are done.
Eigen::MatrixXd release_shares(const Sweep& sweep);

/// Patterns around a point of the box, over all releases.
struct SharesAt {
  std::array<Share, kPatterns> patterns;  ///< in the order of Pattern
  long falls = 0;                         ///< that were counted
};

/// Of the falls of the PatternMap::kNeighbours nearest points (the box has sides of length 1), or of all, if there are
/// fewer. @param point coordinates, SI
/// @throws ArgumentError for other than the sweep's number of coordinates, a point outside its box, or no falls.
SharesAt shares_at(const Sweep& sweep, const Eigen::VectorXd& point);

/// Around a body of the sweep's model, at its own values of the coordinates. All else must be what the sweep held
/// fixed: parameters, and initial values that no release sets, to 1e-9 of them.
/// @throws ArgumentError as shares_at(), and naming what differs: the model, its equations, or the first such value;
/// InputError where the plan of the sweep cannot be read, as without the model's file.
SharesAt shares_of(const Sweep& sweep, const models::ParametricModel& body);

/// Points of a sweep as bodies in the diagram of Re and I*.
struct PlacedBodies {
  std::vector<FallNumbers> bodies;  ///< each once, in the order of points
  Eigen::MatrixXd shares;           ///< bodies x kPatterns, over their points and releases
  std::vector<long> falls;          ///< of each
  std::string missing;              ///< why there are none
};

/// From the model and the values of the sweep's plan. @param most bodies: of more points so many are drawn
PlacedBodies placed_bodies(const Sweep& sweep, Eigen::Index most);

}  // namespace samara::motion
