#pragma once

#include <optional>
#include <string>

#include "samara/flow/grid/body_path.h"
#include "samara/flow/grid/mac_grid.h"
#include "samara/flow/grid/shape.h"
#include "samara/flow/grid/turbulence_model.h"

namespace samara::flow {

/// How far the domain reaches from the body's centre, in body lengths.
struct Extent {
  double before = 10.0, behind = 15.0;
  double side = 8.0;  ///< to each side; in space above and below too
};

/// How a body moves in its domain: its centre from where a held one would be, its angle on top of the angle of attack.
struct BodyMotion {
  BodyPath path;
  std::string text;     ///< what says it, in checkpoints
  double period = 0.0;  ///< l/U, over which its loads repeat; 0: none
};

/// A body in a uniform stream along x with free sides: held, or moving on a path. Lengths are in body lengths l,
/// velocities in U: of a held body that of the stream.
struct FlowCase {
  Shape shape;
  double angle_of_attack = 0.0;  ///< rad
  double reynolds = 0.0;         ///< U l/nu
  double intensity = 0.02;       ///< u'/U of the stream
  TurbulenceModel turbulence = TurbulenceModel::k_epsilon;
  Extent extent = {};
  int cells_per_length = 16;
  double stream = 1.0;  ///< its speed [U]; 0: a body that moves in fluid at rest
  std::optional<BodyMotion> motion = {};
  bool central = false;  ///< central differences for advection instead of van Leer's: laminar verification
};

// Largest numbers of a case, so that the cells of a direction fit into an integer, and steps are not without end.
inline constexpr double kMostExtent = 1000.0;  ///< body lengths
inline constexpr double kMostStream = 1000.0;  ///< U
/// Smallest number of an Extent: the body's half length [body lengths].
inline constexpr double kLeastExtent = 0.5;

/// Share of the stream's width that the body takes.
double blockage(const FlowCase& flow);
/// Memory that the solution of the case takes [bytes].
double memory_of(const FlowCase& flow);
/// @throws ArgumentError, naming value and expectation, for what cannot be solved: no positive Reynolds number, an
/// intensity outside (0, 1], a blockage above 25 %, a body thinner than two cells, a held one within four cells of a
/// border, more than `max_memory`, a held body in a stream of another speed than 1, a stream faster than kMostStream,
/// a path that does not begin with numbers
void check_case(const FlowCase& flow, double max_memory);
/// Of the whole case.
MacGrid grid_of(const FlowCase& flow);

}  // namespace samara::flow
