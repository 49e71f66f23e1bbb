#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "samara/codebooks/book/front_map.h"
#include "samara/codebooks/build/line_nodes.h"

namespace samara::codebooks {

struct FrontFinderOptions {
  Eigen::VectorXd lower, upper;  ///< corners of the box
  std::uint64_t seed = 1;        ///< of the lines that check the place
  long max_points = 60'000;      ///< to be asked for
};

/// Where a front stands along a coordinate of a box, as a polynomial of the other coordinates. On lines through a grid
/// of these the steepest place is looked for; degrees are raised until the polynomial errs by a small part of the width
/// of the front, on lines that are no part of the grid.
/// @param values over their scales, a column per point of the box
/// @returns a map of points of the box; nothing where the front comes near an end of the coordinate, is no smooth
///   sheet, depends on more coordinates than a map knows, or would take too many points
std::optional<FrontMap> find_front(Eigen::Index coordinate, const LineNodes::Values& values,
                                   const FrontFinderOptions& options);

}  // namespace samara::codebooks
