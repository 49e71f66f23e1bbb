#pragma once

#include <array>
#include <functional>

#include <Eigen/Core>

#include "samara/flow/grid/mac_grid.h"

/// What happens at the six borders of the domain, by the margins of the fields.
namespace samara::flow {

enum class BorderKind {
  periodic,  ///< both borders of a direction, or none
  wall,      ///< no slip on a wall that moves along itself at `velocity`
  slip,      ///< no flow across, no shear
  inflow,    ///< velocity given, uniform or by `profile`
  outflow,   ///< pressure 0; what arrives is carried out; scalars have no gradient
};

struct Border {
  BorderKind kind = BorderKind::slip;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of an inflow, or of a wall along itself
  /// Normal component of an inflow at a place of the border; empty: that of `velocity`.
  std::function<double(const Eigen::Vector3d&)> profile = {};
  /// A turbulent wall is seen through the law of the wall (wall_law.h), not resolved.
  bool wall_law = false;
  /// k and eps given on a wall, as those of an inflow are; both 0: no gradient across.
  double k = 0.0, epsilon = 0.0;
};

/// Borders in the order x low, x high, y low, y high, z low, z high.
struct Borders {
  std::array<Border, 6> side;

  const Border& low(int direction) const { return side[static_cast<std::size_t>(2 * direction)]; }
  const Border& high(int direction) const { return side[static_cast<std::size_t>(2 * direction + 1)]; }
  bool periodic(int direction) const { return low(direction).kind == BorderKind::periodic; }
  bool has_outflow() const;
  /// @throws ArgumentError if only one border of a direction is periodic, an outflow is not at an upper border, a wall
  /// moves across itself, a number is not finite, or only one of k and epsilon is positive.
  void check(int dimensions) const;
};

/// Sets the normal velocity on the faces of borders where it is given: 0 at walls and slip, the inflow's value.
/// @throws ArgumentError if a value of a profile is not finite
void set_border_faces(const MacGrid& grid, const Borders& borders, FaceField& velocity);

/// Fills the margins of a velocity, tangential values and continuations.
void fill_margins(const MacGrid& grid, const Borders& borders, FaceField& velocity);

/// Fills the margins of a scalar: periodic, or the same as in the cell at the border.
/// @param given value beyond borders that have one; negative: none
/// @param on_border whether such a value stands on the border itself, half a cell away, and the margin mirrors at it
void fill_margins(const MacGrid& grid, const Borders& borders, Field& scalar,
                  const std::array<double, 6>& given = {-1, -1, -1, -1, -1, -1}, bool on_border = false);

}  // namespace samara::flow
