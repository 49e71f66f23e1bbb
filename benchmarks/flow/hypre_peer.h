#pragma once

#include <memory>

#include "samara/flow/pressure/poisson.h"

namespace samara::benchmarks {

/// The pressure by hypre: conjugate gradients with one V-cycle of its multigrid for structured grids (PFMG) before,
/// on one process. Only where hypre and MPI are found (Debian: libhypre-dev).
class HyprePoisson {
 public:
  /// @param matrix without periodic borders
  explicit HyprePoisson(const flow::PoissonMatrix& matrix);
  ~HyprePoisson();
  HyprePoisson(const HyprePoisson&) = delete;
  HyprePoisson& operator=(const HyprePoisson&) = delete;

  /// From 0, to a residual of `tolerance` over that of the source, in the Euclidean norm. @returns iterations
  int solve(const flow::Field& source, double tolerance);
  /// Of the last solve, the largest |b - A x| over the cells.
  double largest_residual(const flow::Field& source) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace samara::benchmarks
