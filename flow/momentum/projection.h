#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "samara/flow/grid/rows.h"
#include "samara/flow/momentum/momentum_step.h"
#include "samara/flow/pressure/pressure_solver.h"

namespace samara::flow {

/// The second half of a step: the gradient that makes u* free of divergence: sum over a cell's
/// faces of a u = 0, and where a body moves, of a u + (1 - a) u_body (Y. Ng, C. Min, F. Gibou
/// 2009): what it sweeps, the fluid makes way for.
class Projection {
 public:
  /// @param grid, borders, open must outlive this object
  Projection(const MacGrid& grid, const Borders& borders, const Openness& open, PressureSolverKind kind);

  /// After the body has moved, and `open` with it.
  void follow_body(const BodyPose& pose);
  /// u := u* - dt (a/V) grad(change), p := p + change, margins of both filled. What is left of h div u is at most
  /// `tolerance` in every cell where the solve converges.
  PressureSolve project(FlowState& state, double step, double tolerance);
  /// Largest |h div u| over the cells, what the body sweeps included.
  double divergence(const FlowState& state);

 private:
  const MacGrid& grid_;
  const Borders& borders_;
  const Openness& open_;
  void add_swept(double factor);

  PoissonMatrix matrix_;
  std::unique_ptr<PressureSolver> solver_;
  std::vector<std::pair<Index, double>> swept_;  ///< by cells: sum of (1 - a) u_body, outward
  Field source_;
  RowSums sums_;
};

}  // namespace samara::flow
