#include "samara/pgd/linear/factor_system.h"

#include <memory>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace samara::pgd {

namespace {

using Parts = std::vector<ModeOperator>;
using Coefficients = std::vector<Eigen::MatrixXd>;

bool solve_nodes(const Parts& parts, const Coefficients& c, const Eigen::MatrixXd& b, Eigen::MatrixXd& x) {
  const Eigen::Index terms = b.cols();
  Eigen::MatrixXd diagonals = Eigen::MatrixXd::Zero(b.rows(), static_cast<Eigen::Index>(c.size()));
  for (std::size_t i = 0; i < c.size(); ++i) {
    parts[i].add_to_diagonal(diagonals.col(static_cast<Eigen::Index>(i)), 1.0);
  }
  Eigen::MatrixXd result(b.rows(), terms);
  Eigen::MatrixXd system(terms, terms);
  Eigen::PartialPivLU<Eigen::MatrixXd> lu(terms);
  for (Eigen::Index p = 0; p < b.rows(); ++p) {
    system.setZero();
    for (std::size_t i = 0; i < c.size(); ++i) system += diagonals(p, static_cast<Eigen::Index>(i)) * c[i];
    lu.compute(system);
    result.row(p) = lu.solve(b.row(p).transpose()).transpose();
    if (!is_plausible(system.cwiseAbs().maxCoeff(), b.row(p).norm(), result.row(p).norm())) return false;
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

bool solve_dense(const Parts& parts, const Coefficients& c, const Eigen::MatrixXd& b, Eigen::MatrixXd& x) {
  const Eigen::Index terms = b.cols();
  std::vector<Eigen::MatrixXd> matrices;
  for (const ModeOperator& part : parts)
    matrices.push_back(part.apply(Eigen::MatrixXd::Identity(b.rows(), b.rows())));
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
    const Eigen::VectorXd solution = lu.solve(Eigen::Map<const Eigen::VectorXd>(rhs.data(), rhs.size()));
    if (!is_plausible(system.cwiseAbs().maxCoeff(), rhs.norm(), solution.norm())) return false;
    result.middleRows(first, n) = Eigen::Map<const Eigen::MatrixXd>(solution.data(), n, terms);
  }
  if (!result.allFinite()) return false;
  x = std::move(result);
  return true;
}

bool solve_sparse(const Parts& parts, const Coefficients& c, const Eigen::MatrixXd& b, SparseSolverKind kind,
                  Eigen::MatrixXd& x) {
  const auto n = static_cast<int>(b.rows());
  const auto terms = static_cast<int>(b.cols());
  std::vector<Eigen::Triplet<double>> part;
  std::vector<Eigen::Triplet<double>> triplets;
  // Unknowns are numbered node by node, which keeps the band of the axis.
  for (std::size_t i = 0; i < c.size(); ++i) {
    part.clear();
    parts[i].add_to_triplets(part, 0, 0, 1.0);
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
  const std::unique_ptr<SparseSolver> solver = make_sparse_solver(kind, system);
  Eigen::MatrixXd solution(by_node.size(), 1);
  if (!solver->factorize(system)) return false;
  if (!solver->solve(Eigen::Map<const Eigen::VectorXd>(by_node.data(), by_node.size()), solution))
    return false;
  if (!is_plausible(system.coeffs().cwiseAbs().maxCoeff(), b.norm(), solution.norm())) return false;
  x = Eigen::Map<const Eigen::MatrixXd>(solution.data(), terms, n).transpose();
  return true;
}

bool is_symmetric(const Eigen::MatrixXd& matrix) {
  return (matrix - matrix.transpose()).cwiseAbs().maxCoeff() <= 1e-12 * matrix.cwiseAbs().maxCoeff();
}

/// One factor for each term: V^T C_p V diagonal for all p, so that X = Z V^T with independent columns of Z.
struct Decoupled {
  Eigen::MatrixXd vectors;       ///< V, terms x terms
  Eigen::MatrixXd coefficients;  ///< diagonals of V^T C_p V, parts x terms
};

/// Simultaneous diagonalisation of one or two symmetric matrices, one of them positive: the better
/// conditioned one takes that place. Empty if they are not, or the positive one is nearly singular.
std::optional<Decoupled> decouple(const Coefficients& c) {
  if (c.size() > 2) return std::nullopt;
  constexpr double kRegular = 1e-13;
  std::size_t positive = 0;
  double best = 0.0;
  for (std::size_t p = 0; p < c.size(); ++p) {
    if (!is_symmetric(c[p])) return std::nullopt;
    const Eigen::LLT<Eigen::MatrixXd> factor(c[p]);
    const double condition = factor.info() == Eigen::Success ? factor.rcond() : 0.0;
    if (condition > best) {
      best = condition;
      positive = p;
    }
  }
  if (best < kRegular) return std::nullopt;
  const Eigen::MatrixXd& other = c[c.size() - 1 - positive];
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(other, c[positive]);
  if (eigen.info() != Eigen::Success) return std::nullopt;
  Decoupled result;
  result.vectors = eigen.eigenvectors();
  result.coefficients.resize(static_cast<Eigen::Index>(c.size()), other.cols());
  result.coefficients.row(static_cast<Eigen::Index>(c.size() - 1 - positive)) =
      eigen.eigenvalues().transpose();
  result.coefficients.row(static_cast<Eigen::Index>(positive)).setOnes();
  return result;
}

bool solve_decoupled(ModeSystem& system, const Decoupled& decoupled, const Eigen::MatrixXd& b,
                     Eigen::MatrixXd& x) {
  const Eigen::MatrixXd rhs = b * decoupled.vectors;
  Eigen::MatrixXd z(b.rows(), b.cols());
  for (Eigen::Index j = 0; j < z.cols(); ++j) {
    if (!system.solve(decoupled.coefficients.col(j), rhs.col(j), z.col(j))) return false;
  }
  x.noalias() = z * decoupled.vectors.transpose();
  return true;
}

}  // namespace

bool solve_factor_system(ModeSystem& system, const std::vector<Eigen::MatrixXd>& c, const Eigen::MatrixXd& b,
                         SparseSolverKind kind, Eigen::MatrixXd& x) {
  if (system.structure() == ModeOperator::Structure::diagonal) return solve_nodes(system.parts(), c, b, x);
  if (system.structure() == ModeOperator::Structure::dense) return solve_dense(system.parts(), c, b, x);
  if (const std::optional<Decoupled> decoupled = decouple(c))
    return solve_decoupled(system, *decoupled, b, x);
  return solve_sparse(system.parts(), c, b, kind, x);
}

}  // namespace samara::pgd
