#pragma once

#include <vector>

#include "samara/flow/grid/rows.h"
#include "samara/flow/pressure/pressure_solver.h"

namespace samara::flow {

/// Conjugate gradients preconditioned by one V(2,2) cycle: red-black Gauss-Seidel, in reverse on the
/// way up so that the preconditioner is symmetric; piecewise constant transfer; grids down to single
/// cells. All memory is taken at the start.
class MultigridSolver final : public PressureSolver {
 public:
  explicit MultigridSolver(PoissonMatrix matrix);
  PressureSolve solve(Field& b, Field& x, double tolerance) override;
  void set_matrix(const PoissonMatrix& matrix) override;

 private:
  struct Level {
    PoissonMatrix matrix;
    Field x, b, residual;

    explicit Level(PoissonMatrix of);
  };

  void sweep(Level& level, int colour) const;
  void smooth(Level& level, int sweeps, int first_colour, bool from_zero) const;
  void restrict_residual(Level& fine, Level& coarse) const;
  void prolong(const Level& coarse, Level& fine) const;
  /// levels_[0].x = M^-1 levels_[0].b
  void cycle();
  double dot(const Field& a, const Field& b);
  void remove_mean(Field& field);
  void count_active_cells();

  std::vector<Level> levels_;
  Field direction_, product_;
  RowSums sums_;
  double active_cells_ = 0.0;
};

}  // namespace samara::flow
