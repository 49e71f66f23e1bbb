#include "hypre_peer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <HYPRE_struct_ls.h>
#include <mpi.h>

namespace samara::benchmarks {

namespace {

void check(int error, const char* what) {
  if (error != 0) throw std::runtime_error(std::string("hypre: ") + what + " failed");
}

/// MPI is there as long as the program.
struct Environment {
  Environment() {
    MPI_Init(nullptr, nullptr);
    HYPRE_Init();
  }
  ~Environment() {
    HYPRE_Finalize();
    MPI_Finalize();
  }
};

}  // namespace

struct HyprePoisson::Parts {
  explicit Parts(const flow::PoissonMatrix& of) : matrix(of) {}

  const flow::PoissonMatrix& matrix;
  std::vector<int> low = {0, 0, 0}, high;
  HYPRE_StructGrid grid = nullptr;
  HYPRE_StructStencil stencil = nullptr;
  HYPRE_StructMatrix A = nullptr;
  HYPRE_StructVector b = nullptr, x = nullptr;
  HYPRE_StructSolver solver = nullptr, before = nullptr;
  std::vector<double> numbers;  ///< of all cells, x running fastest

  /// visit(cell, its place in fields)
  template <class Visit>
  void for_cells(const Visit& visit) const {
    std::size_t cell = 0;
    const flow::MacGrid& on = matrix.grid;
    for (int k = 0; k < on.cells[2]; ++k) {
      for (int j = 0; j < on.cells[1]; ++j) {
        for (int i = 0; i < on.cells[0]; ++i)
          visit(cell++, std::array{i, j, k}, static_cast<std::size_t>(on.at(i, j, k)));
      }
    }
  }
};

HyprePoisson::HyprePoisson(const flow::PoissonMatrix& matrix) : parts_(std::make_unique<Parts>(matrix)) {
  static const Environment environment;
  Parts& p = *parts_;
  const flow::MacGrid& on = matrix.grid;
  const int d = on.dimensions;
  for (const int cells : on.cells) p.high.push_back(cells - 1);
  check(HYPRE_StructGridCreate(MPI_COMM_WORLD, d, &p.grid), "the grid");
  HYPRE_StructGridSetExtents(p.grid, p.low.data(), p.high.data());
  check(HYPRE_StructGridAssemble(p.grid), "the grid");
  // The matrix is symmetric: the diagonal and the upper neighbours.
  HYPRE_StructStencilCreate(d, d + 1, &p.stencil);
  for (int entry = 0; entry <= d; ++entry) {
    int offset[3] = {};
    if (entry > 0) offset[entry - 1] = 1;
    HYPRE_StructStencilSetElement(p.stencil, entry, offset);
  }
  HYPRE_StructMatrixCreate(MPI_COMM_WORLD, p.grid, p.stencil, &p.A);
  HYPRE_StructMatrixSetSymmetric(p.A, 1);
  HYPRE_StructMatrixInitialize(p.A);
  p.numbers.resize(static_cast<std::size_t>(on.cell_count()));
  for (int entry = 0; entry <= d; ++entry) {
    p.for_cells([&](std::size_t cell, const std::array<int, 3>& place, std::size_t at) {
      if (entry == 0) {
        // Closed cells have an equation of their own: x = 0.
        p.numbers[cell] = matrix.inverse_diagonal[at] > 0.0 ? 1.0 / matrix.inverse_diagonal[at] : 1.0;
        return;
      }
      const auto direction = static_cast<std::size_t>(entry - 1);
      const bool is_last = place[direction] + 1 == on.cells[direction];
      p.numbers[cell] =
          is_last ? 0.0 : -matrix.weight[direction][at + static_cast<std::size_t>(on.stride[direction])];
    });
    HYPRE_StructMatrixSetBoxValues(p.A, p.low.data(), p.high.data(), 1, &entry, p.numbers.data());
  }
  check(HYPRE_StructMatrixAssemble(p.A), "the matrix");
  for (HYPRE_StructVector* vector : {&p.b, &p.x}) {
    HYPRE_StructVectorCreate(MPI_COMM_WORLD, p.grid, vector);
    HYPRE_StructVectorInitialize(*vector);
    HYPRE_StructVectorAssemble(*vector);
  }
  HYPRE_StructPFMGCreate(MPI_COMM_WORLD, &p.before);
  HYPRE_StructPFMGSetMaxIter(p.before, 1);
  HYPRE_StructPFMGSetTol(p.before, 0.0);
  HYPRE_StructPFMGSetZeroGuess(p.before);
  HYPRE_StructPFMGSetRelaxType(p.before, 2);  // symmetric red-black Gauss-Seidel
  HYPRE_StructPFMGSetNumPreRelax(p.before, 1);
  HYPRE_StructPFMGSetNumPostRelax(p.before, 1);
  HYPRE_StructPCGCreate(MPI_COMM_WORLD, &p.solver);
  HYPRE_StructPCGSetMaxIter(p.solver, 500);
  HYPRE_StructPCGSetTwoNorm(p.solver, 1);
  HYPRE_StructPCGSetPrecond(p.solver, HYPRE_StructPFMGSolve, HYPRE_StructPFMGSetup, p.before);
  check(HYPRE_StructPCGSetup(p.solver, p.A, p.b, p.x), "the setup");
}

HyprePoisson::~HyprePoisson() {
  Parts& p = *parts_;
  HYPRE_StructPCGDestroy(p.solver);
  HYPRE_StructPFMGDestroy(p.before);
  HYPRE_StructVectorDestroy(p.b);
  HYPRE_StructVectorDestroy(p.x);
  HYPRE_StructMatrixDestroy(p.A);
  HYPRE_StructStencilDestroy(p.stencil);
  HYPRE_StructGridDestroy(p.grid);
}

int HyprePoisson::solve(const flow::Field& source, double tolerance) {
  Parts& p = *parts_;
  p.for_cells([&](std::size_t cell, const auto&, std::size_t at) {
    p.numbers[cell] = p.matrix.inverse_diagonal[at] > 0.0 ? source[at] : 0.0;
  });
  HYPRE_StructVectorSetBoxValues(p.b, p.low.data(), p.high.data(), p.numbers.data());
  HYPRE_StructVectorSetConstantValues(p.x, 0.0);
  HYPRE_StructPCGSetTol(p.solver, tolerance);
  HYPRE_StructPCGSolve(p.solver, p.A, p.b, p.x);
  HYPRE_ClearAllErrors();  // what is not reached shows in the residual
  int iterations = 0;
  HYPRE_StructPCGGetNumIterations(p.solver, &iterations);
  return iterations;
}

double HyprePoisson::largest_residual(const flow::Field& source) const {
  Parts& p = *parts_;
  HYPRE_StructVectorGetBoxValues(p.x, p.low.data(), p.high.data(), p.numbers.data());
  flow::Field x = p.matrix.grid.field(), r = x;
  p.for_cells([&](std::size_t cell, const auto&, std::size_t at) { x[at] = p.numbers[cell]; });
  double largest = 0.0;
  const flow::MacGrid& on = p.matrix.grid;
  for (int k = 0; k < on.cells[2]; ++k) {
    for (int j = 0; j < on.cells[1]; ++j)
      p.matrix.residual_row(on.at(0, j, k), source.data(), x.data(), r.data());
  }
  p.for_cells([&](std::size_t, const auto&, std::size_t at) {
    if (p.matrix.inverse_diagonal[at] > 0.0) largest = std::max(largest, std::abs(r[at]));
  });
  return largest;
}

}  // namespace samara::benchmarks
