#pragma once

#include <memory>

#include "samara/flow/pressure/poisson.h"

namespace samara::flow {

enum class PressureSolverKind {
  automatic,  ///< multigrid: faster than triangular solves at every size that was measured
  multigrid,  ///< conjugate gradients, preconditioned by one V-cycle
  direct,     ///< factorised once by pgd/linear/sparse_solver.h: bodies that are held, in the plane
};

/// How one solve went.
struct PressureSolve {
  int iterations = 0;     ///< 0 of the direct solver
  double residual = 0.0;  ///< largest |b - A x| over the cells
  bool converged = false;
};

class PressureSolver {
 public:
  virtual ~PressureSolver() = default;
  /// A x = b to a largest residual of `tolerance`, from x as it is. b is made to sum to 0 first where
  /// nothing fixes the level; the mean of x is then 0. Margins of x are filled at periodic borders;
  /// elsewhere they must be 0, and stay so.
  virtual PressureSolve solve(Field& b, Field& x, double tolerance) = 0;
  /// For another body, or one that has moved, on the same grid. @throws ArgumentError as make_pressure_solver() does
  virtual void set_matrix(const PoissonMatrix& matrix) = 0;
};

/// @throws ArgumentError if the factorisation of the direct solver fails.
std::unique_ptr<PressureSolver> make_pressure_solver(PressureSolverKind kind, PoissonMatrix matrix);

/// Largest number of iterations of the multigrid solver.
inline constexpr int kMostPressureIterations = 200;

}  // namespace samara::flow
