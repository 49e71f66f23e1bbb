#include "samara/flow/pressure/pressure_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/flow/pressure/multigrid.h"
#include "samara/pgd/linear/sparse_solver.h"

namespace samara::flow {

namespace {

/// The matrix of the cells that have open faces, factorised once. Regions whose level nothing fixes get it from one of
/// their cells, which is held at 0.
class DirectPressure final : public PressureSolver {
 public:
  explicit DirectPressure(PoissonMatrix matrix)
      : matrix_(std::move(matrix)), number_(matrix_.grid.field()), residual_(matrix_.grid.field()) {
    factorize();
  }

  void set_matrix(const PoissonMatrix& matrix) override {
    matrix_ = matrix;
    factorize();
  }

  PressureSolve solve(Field& b, Field& x, double tolerance) override {
    const auto count = static_cast<Eigen::Index>(cells_.size());
    for (Eigen::Index i = 0; i < count; ++i) right_(i, 0) = b[place(i)];
    if (!matrix_.fixes_level) {
      right_.array() -= right_.mean();
      for (Eigen::Index i = 0; i < count; ++i) b[place(i)] = right_(i, 0);
    }
    for (const Eigen::Index held : held_) right_(held, 0) = 0.0;
    PressureSolve report;
    report.converged = solver_->solve(right_, answer_);
    if (!matrix_.fixes_level) answer_.array() -= answer_.mean();
    for (Eigen::Index i = 0; i < count; ++i) x[place(i)] = answer_(i, 0);
    matrix_.fill_margins(x);
    for (int row = 0; row < matrix_.grid.cells[1] * matrix_.grid.cells[2]; ++row)
      matrix_.residual_row(matrix_.grid.at(0, row % matrix_.grid.cells[1], row / matrix_.grid.cells[1]),
                           b.data(), x.data(), residual_.data());
    double sum = 0.0;
    for (const Index c : cells_) {
      const double size = std::abs(residual_[static_cast<std::size_t>(c)]);
      report.residual = std::max(report.residual, size);
      sum += size;
    }
    // A maximum passes over what is no number.
    if (!std::isfinite(sum)) report.residual = INFINITY;
    report.converged = report.converged && report.residual <= tolerance;
    return report;
  }

 private:
  void factorize() {
    const MacGrid& grid = matrix_.grid;
    cells_.clear();
    held_.clear();
    for (int k = 0; k < grid.cells[2]; ++k) {
      for (int j = 0; j < grid.cells[1]; ++j) {
        for (int i = 0; i < grid.cells[0]; ++i) {
          const Index c = grid.at(i, j, k);
          if (matrix_.inverse_diagonal[static_cast<std::size_t>(c)] == 0.0) continue;
          number_[static_cast<std::size_t>(c)] = static_cast<double>(cells_.size());
          cells_.push_back(c);
        }
      }
    }
    matrix_.fill_margins(number_);
    assemble();
    solver_ = pgd::make_sparse_solver(pgd::is_available(pgd::SparseSolverKind::cholmod)
                                          ? pgd::SparseSolverKind::cholmod
                                          : pgd::SparseSolverKind::eigen_ldlt,
                                      sparse_);
    if (!solver_->factorize(sparse_))
      throw ArgumentError("the matrix of the pressure could not be factorised");
    right_.resize(sparse_.rows(), 1);
    answer_.resize(sparse_.rows(), 1);
  }

  std::size_t place(Eigen::Index i) const {
    return static_cast<std::size_t>(cells_[static_cast<std::size_t>(i)]);
  }

  /// f(neighbour, weight) of the neighbours of a cell; -1 stands for the outflow.
  template <class Function>
  void for_neighbours(Index c, const Function& f) const {
    for (int d = 0; d < matrix_.grid.dimensions; ++d) {
      const auto at = static_cast<std::size_t>(d);
      const Index s = matrix_.grid.stride[at];
      const double low = matrix_.weight[at][static_cast<std::size_t>(c)];
      const double high = matrix_.weight[at][static_cast<std::size_t>(c + s)];
      const Index position = (c - matrix_.grid.first) / s % (matrix_.grid.cells[at] + 2 * MacGrid::kMargin);
      const bool at_end = !matrix_.periodic[at] && position == matrix_.grid.cells[at] - 1;
      if (low > 0.0) f(static_cast<int>(number_[static_cast<std::size_t>(c - s)]), low);
      if (high > 0.0) f(at_end ? -1 : static_cast<int>(number_[static_cast<std::size_t>(c + s)]), high);
    }
  }

  /// One cell of every connected region without an outflow.
  void choose_held() {
    std::vector<char> seen(cells_.size(), 0);
    std::vector<int> open;
    for (std::size_t start = 0; start < cells_.size(); ++start) {
      if (seen[start]) continue;
      bool fixed = false;
      seen[start] = 1;
      open.assign(1, static_cast<int>(start));
      while (!open.empty()) {
        const int cell = open.back();
        open.pop_back();
        for_neighbours(cells_[static_cast<std::size_t>(cell)], [&](int neighbour, double) {
          if (neighbour < 0) {
            fixed = true;
          } else if (!seen[static_cast<std::size_t>(neighbour)]) {
            seen[static_cast<std::size_t>(neighbour)] = 1;
            open.push_back(neighbour);
          }
        });
      }
      if (!fixed) held_.push_back(static_cast<Eigen::Index>(start));
    }
  }

  void assemble() {
    choose_held();
    const auto is_held = [&](int i) { return std::find(held_.begin(), held_.end(), i) != held_.end(); };
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(cells_.size() * 5);
    for (int i = 0; i < static_cast<int>(cells_.size()); ++i) {
      double diagonal = 0.0;
      const bool held = is_held(i);
      for_neighbours(cells_[static_cast<std::size_t>(i)], [&](int neighbour, double w) {
        diagonal += w;
        if (neighbour >= 0 && !held && !is_held(neighbour)) entries.emplace_back(i, neighbour, -w);
      });
      entries.emplace_back(i, i, diagonal);
    }
    const auto n = static_cast<Eigen::Index>(cells_.size());
    sparse_.resize(n, n);
    sparse_.setFromTriplets(entries.begin(), entries.end());
  }

  PoissonMatrix matrix_;
  std::vector<Index> cells_;
  Field number_;  ///< of the cell among the unknowns
  std::vector<Eigen::Index> held_;
  pgd::SparseMatrix sparse_;
  std::unique_ptr<pgd::SparseSolver> solver_;
  Eigen::MatrixXd right_, answer_;
  Field residual_;
};

}  // namespace

std::unique_ptr<PressureSolver> make_pressure_solver(PressureSolverKind kind, PoissonMatrix matrix) {
  if (kind == PressureSolverKind::direct) return std::make_unique<DirectPressure>(std::move(matrix));
  return std::make_unique<MultigridSolver>(std::move(matrix));
}

}  // namespace samara::flow
