#pragma once

#include <memory>

#include "samara/flow/grid/rows.h"
#include "samara/flow/momentum/momentum_step.h"
#include "samara/flow/pressure/pressure_solver.h"

namespace samara::flow {

/// The second half of a step: the gradient that makes u* free of divergence, sum over a cell's faces of a u = 0.
class Projection {
 public:
  /// @param grid, borders, open must outlive this object
  Projection(const MacGrid& grid, const Borders& borders, const Openness& open, PressureSolverKind kind);

  /// u := u* - dt (a/V) grad(change), p := p + change, margins of both filled. What is left of h div u is at most
  /// `tolerance` in every cell where the solve converges.
  PressureSolve project(FlowState& state, double step, double tolerance);
  /// Largest |h div u| over the cells.
  double divergence(const FlowState& state);

 private:
  const MacGrid& grid_;
  const Borders& borders_;
  const Openness& open_;
  std::unique_ptr<PressureSolver> solver_;
  Field source_;
  RowSums sums_;
};

}  // namespace samara::flow
