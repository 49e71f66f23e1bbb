#include "samara/pgd/mode_system.h"

#include <cmath>
#include <limits>
#include <utility>

namespace samara::pgd {

namespace {
using Structure = ModeOperator::Structure;

/// LU by rows breaks down silently: its smallest pivot against the largest tells.
bool is_regular(const Eigen::PartialPivLU<Eigen::MatrixXd>& lu) {
  const auto pivots = lu.matrixLU().diagonal().cwiseAbs();
  return pivots.minCoeff() > std::numeric_limits<double>::epsilon() * 1e-3 * pivots.maxCoeff();
}
}  // namespace

ModeSystem::ModeSystem(const SeparatedOperator& a, int mode)
    : a_(a), mode_(static_cast<std::size_t>(mode)), structure_(a.structure(mode)) {
  const Eigen::Index n = a.size(mode);
  if (structure_ == Structure::diagonal) {
    diagonal_.resize(n);
  } else if (structure_ == Structure::dense) {
    matrix_.resize(n, n);
    lu_ = Eigen::PartialPivLU<Eigen::MatrixXd>(n);
  } else {
    std::vector<Eigen::Triplet<double>> triplets;
    for (const auto& term : a.terms) term[mode_].add_to_triplets(triplets, 0, 0, 1.0);
    pattern_.resize(n, n);
    pattern_.setFromTriplets(triplets.begin(), triplets.end());
    for (const auto& term : a.terms) {
      triplets.clear();
      term[mode_].add_to_triplets(triplets, 0, 0, 1.0);
      SparseMatrix part(n, n);
      part.setFromTriplets(triplets.begin(), triplets.end());
      const SparseMatrix on_pattern = 0.0 * pattern_ + part;
      sparse_values_.emplace_back(
          Eigen::Map<const Eigen::VectorXd>(on_pattern.valuePtr(), on_pattern.nonZeros()));
    }
    sparse_lu_ = std::make_unique<Eigen::SparseLU<SparseMatrix>>();
    sparse_lu_->analyzePattern(pattern_);
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
  for (std::size_t i = 0; i < a_.terms.size(); ++i) {
    a_.terms[i][mode_].add_to_diagonal(diagonal_, coefficients[static_cast<Eigen::Index>(i)]);
  }
  x = rhs.cwiseQuotient(diagonal_);
  return x.allFinite();
}

bool ModeSystem::solve_dense(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs,
                             Eigen::Ref<Eigen::VectorXd> x) {
  matrix_.setZero();
  for (std::size_t i = 0; i < a_.terms.size(); ++i) {
    a_.terms[i][mode_].add_to_dense(matrix_, coefficients[static_cast<Eigen::Index>(i)]);
  }
  lu_.compute(matrix_);
  if (!is_regular(lu_)) return false;
  x = lu_.solve(rhs);
  return x.allFinite();
}

bool ModeSystem::solve_sparse(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs,
                              Eigen::Ref<Eigen::VectorXd> x) {
  Eigen::Map<Eigen::VectorXd> values(pattern_.valuePtr(), pattern_.nonZeros());
  values.setZero();
  for (std::size_t i = 0; i < sparse_values_.size(); ++i) {
    values += coefficients[static_cast<Eigen::Index>(i)] * sparse_values_[i];
  }
  sparse_lu_->factorize(pattern_);
  if (sparse_lu_->info() != Eigen::Success) return false;
  x = sparse_lu_->solve(rhs);
  return x.allFinite();
}

namespace {

bool solve_nodes(const SeparatedOperator& a, std::size_t mode, std::span<const Eigen::MatrixXd> c,
                 const Eigen::MatrixXd& b, Eigen::MatrixXd& x) {
  const Eigen::Index terms = b.cols();
  Eigen::MatrixXd diagonals = Eigen::MatrixXd::Zero(b.rows(), static_cast<Eigen::Index>(c.size()));
  for (std::size_t i = 0; i < c.size(); ++i) {
    a.terms[i][mode].add_to_diagonal(diagonals.col(static_cast<Eigen::Index>(i)), 1.0);
  }
  Eigen::MatrixXd result(b.rows(), terms);
  Eigen::MatrixXd system(terms, terms);
  Eigen::PartialPivLU<Eigen::MatrixXd> lu(terms);
  for (Eigen::Index p = 0; p < b.rows(); ++p) {
    system.setZero();
    for (std::size_t i = 0; i < c.size(); ++i) system += diagonals(p, static_cast<Eigen::Index>(i)) * c[i];
    lu.compute(system);
    if (!is_regular(lu)) return false;
    result.row(p) = lu.solve(b.row(p).transpose()).transpose();
  }
  if (!result.allFinite()) return false;
  x = std::move(result);
  return true;
}

/// Where a block lower triangular structure common to all matrices allows a cut: 0, cuts.., n. Causal
/// operators, such as integration over time elements, have one cut per element.
std::vector<Eigen::Index> block_cuts(const std::vector<Eigen::MatrixXd>& matrices) {
  const Eigen::Index n = matrices.front().rows();
  std::vector<Eigen::Index> cuts = {0};
  Eigen::Index reach = 0;  // one past the last column that a row so far refers to
  for (Eigen::Index row = 0; row < n; ++row) {
    for (const Eigen::MatrixXd& matrix : matrices) {
      for (Eigen::Index col = n; col > reach; --col) {
        if (matrix(row, col - 1) != 0.0) reach = col;
      }
    }
    if (reach <= row + 1) cuts.push_back(row + 1);
  }
  if (cuts.back() != n) cuts.push_back(n);
  return cuts;
}

bool solve_dense_factor(const SeparatedOperator& a, std::size_t mode, std::span<const Eigen::MatrixXd> c,
                        const Eigen::MatrixXd& b, Eigen::MatrixXd& x) {
  const Eigen::Index terms = b.cols();
  std::vector<Eigen::MatrixXd> matrices;
  for (const auto& term : a.terms)
    matrices.push_back(term[mode].apply(Eigen::MatrixXd::Identity(b.rows(), b.rows())));
  const std::vector<Eigen::Index> cuts = block_cuts(matrices);
  Eigen::MatrixXd result(b.rows(), terms);
  // Block forward substitution; with a single block this is the full system.
  for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
    const Eigen::Index first = cuts[k];
    const Eigen::Index n = cuts[k + 1] - first;
    Eigen::MatrixXd rhs = b.middleRows(first, n);
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n * terms, n * terms);
    for (std::size_t i = 0; i < c.size(); ++i) {
      rhs.noalias() -= matrices[i].block(first, 0, n, first) * result.topRows(first) * c[i].transpose();
      for (Eigen::Index row = 0; row < terms; ++row) {
        for (Eigen::Index col = 0; col < terms; ++col) {
          system.block(row * n, col * n, n, n) += c[i](row, col) * matrices[i].block(first, first, n, n);
        }
      }
    }
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(system);
    if (!is_regular(lu)) return false;
    const Eigen::VectorXd solution = lu.solve(Eigen::Map<const Eigen::VectorXd>(rhs.data(), rhs.size()));
    result.middleRows(first, n) = Eigen::Map<const Eigen::MatrixXd>(solution.data(), n, terms);
  }
  if (!result.allFinite()) return false;
  x = std::move(result);
  return true;
}

bool solve_sparse_factor(const SeparatedOperator& a, std::size_t mode, std::span<const Eigen::MatrixXd> c,
                         const Eigen::MatrixXd& b, Eigen::MatrixXd& x) {
  const auto n = static_cast<int>(b.rows());
  const auto terms = static_cast<int>(b.cols());
  std::vector<Eigen::Triplet<double>> part;
  std::vector<Eigen::Triplet<double>> triplets;
  // Unknowns are numbered node by node, which keeps the band of the axis.
  for (std::size_t i = 0; i < c.size(); ++i) {
    part.clear();
    a.terms[i][mode].add_to_triplets(part, 0, 0, 1.0);
    for (const auto& entry : part) {
      for (int row = 0; row < terms; ++row) {
        for (int col = 0; col < terms; ++col) {
          triplets.emplace_back(entry.row() * terms + row, entry.col() * terms + col,
                                entry.value() * c[i](row, col));
        }
      }
    }
  }
  SparseMatrix system(n * terms, n * terms);
  system.setFromTriplets(triplets.begin(), triplets.end());
  const Eigen::MatrixXd by_node = b.transpose();
  Eigen::SparseLU<SparseMatrix> lu(system);
  if (lu.info() != Eigen::Success) return false;
  const Eigen::VectorXd solution =
      lu.solve(Eigen::Map<const Eigen::VectorXd>(by_node.data(), by_node.size()));
  if (lu.info() != Eigen::Success || !solution.allFinite()) return false;
  x = Eigen::Map<const Eigen::MatrixXd>(solution.data(), terms, n).transpose();
  return true;
}

}  // namespace

bool solve_factor_system(const SeparatedOperator& a, int mode, std::span<const Eigen::MatrixXd> c,
                         const Eigen::MatrixXd& b, Eigen::MatrixXd& x) {
  const auto k = static_cast<std::size_t>(mode);
  switch (a.structure(mode)) {
    case Structure::diagonal:
      return solve_nodes(a, k, c, b, x);
    case Structure::sparse:
      return solve_sparse_factor(a, k, c, b, x);
    case Structure::dense:
      return solve_dense_factor(a, k, c, b, x);
  }
  return false;
}

}  // namespace samara::pgd
