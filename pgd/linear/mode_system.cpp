#include "samara/pgd/linear/mode_system.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace samara::pgd {

namespace {
using Structure = ModeOperator::Structure;

/// Index of an entry of a compressed matrix among its stored values.
Eigen::Index place_of(const SparseMatrix& matrix, int row, int col) {
  const int* begin = matrix.innerIndexPtr() + matrix.outerIndexPtr()[col];
  const int* end = matrix.innerIndexPtr() + matrix.outerIndexPtr()[col + 1];
  return std::lower_bound(begin, end, row) - matrix.innerIndexPtr();
}
}  // namespace

Structure sum_structure(const std::vector<ModeOperator>& parts) {
  Structure least = Structure::diagonal;
  for (const ModeOperator& part : parts) least = std::max(least, part.structure());
  return least;
}

bool is_plausible(double largest_entry, double rhs_norm, double solution_norm) {
  constexpr double kLargestGrowth = 1e14;
  return std::isfinite(solution_norm) && largest_entry * solution_norm <= kLargestGrowth * rhs_norm;
}

SparseMatrix sparse_sum(const std::vector<ModeOperator>& parts, const Eigen::VectorXd& coefficients) {
  std::vector<Eigen::Triplet<double>> triplets;
  for (std::size_t p = 0; p < parts.size(); ++p)
    parts[p].add_to_triplets(triplets, 0, 0, coefficients[static_cast<Eigen::Index>(p)]);
  SparseMatrix sum(parts.front().rows(), parts.front().cols());
  sum.setFromTriplets(triplets.begin(), triplets.end());
  return sum;
}

ModeSystem::ModeSystem(const std::vector<ModeOperator>& parts, SparseSolverKind kind)
    : parts_(&parts), structure_(sum_structure(parts)) {
  const Eigen::Index n = parts.front().cols();
  if (structure_ == Structure::diagonal) {
    diagonal_.resize(n);
  } else if (structure_ == Structure::dense) {
    matrix_.resize(n, n);
    lu_ = Eigen::PartialPivLU<Eigen::MatrixXd>(n);
  } else {
    pattern_ = sparse_sum(parts, Eigen::VectorXd::Ones(static_cast<Eigen::Index>(parts.size())));
    const Eigen::VectorXd zeros = Eigen::VectorXd::Zero(pattern_.nonZeros());
    std::vector<Eigen::Triplet<double>> triplets;
    for (const ModeOperator& part : parts) {
      triplets.clear();
      part.add_to_triplets(triplets, 0, 0, 1.0);
      Eigen::VectorXd& values = sparse_values_.emplace_back(zeros);
      for (const auto& entry : triplets)
        values[place_of(pattern_, entry.row(), entry.col())] += entry.value();
    }
    sparse_ = make_sparse_solver(kind, pattern_);
  }
}

bool ModeSystem::solve(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs,
                       Eigen::Ref<Eigen::VectorXd> x) {
  switch (structure_) {
    case Structure::diagonal:
      return solve_diagonal(coefficients, rhs, x);
    case Structure::dense:
      return solve_dense(coefficients, rhs, x);
    case Structure::sparse:
      return solve_sparse(coefficients, rhs, x);
  }
  return false;
}

bool ModeSystem::solve_diagonal(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs,
                                Eigen::Ref<Eigen::VectorXd> x) {
  diagonal_.setZero();
  for (std::size_t i = 0; i < parts_->size(); ++i)
    (*parts_)[i].add_to_diagonal(diagonal_, coefficients[static_cast<Eigen::Index>(i)]);
  x = rhs.cwiseQuotient(diagonal_);
  return x.allFinite();
}

bool ModeSystem::solve_dense(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs,
                             Eigen::Ref<Eigen::VectorXd> x) {
  matrix_.setZero();
  for (std::size_t i = 0; i < parts_->size(); ++i)
    (*parts_)[i].add_to_dense(matrix_, coefficients[static_cast<Eigen::Index>(i)]);
  lu_.compute(matrix_);
  x = lu_.solve(rhs);
  return is_plausible(matrix_.cwiseAbs().maxCoeff(), rhs.norm(), x.norm());
}

bool ModeSystem::solve_sparse(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs,
                              Eigen::Ref<Eigen::VectorXd> x) {
  Eigen::Map<Eigen::VectorXd> values(pattern_.valuePtr(), pattern_.nonZeros());
  values.setZero();
  for (std::size_t i = 0; i < sparse_values_.size(); ++i) {
    values += coefficients[static_cast<Eigen::Index>(i)] * sparse_values_[i];
  }
  return sparse_->factorize(pattern_) && sparse_->solve(rhs, x) &&
         is_plausible(values.cwiseAbs().maxCoeff(), rhs.norm(), x.norm());
}

std::vector<ModeSystem> make_mode_systems(const OperatorChain& chain, SparseSolverKind kind) {
  std::vector<ModeSystem> systems;
  for (int k = 0; k < chain.modes(); ++k) systems.emplace_back(chain.mode(k).parts, kind);
  return systems;
}

}  // namespace samara::pgd
