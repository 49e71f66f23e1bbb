#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SparseLU>

#include "samara/pgd/separated_operator.h"

namespace samara::pgd {

/// The 1-D problems of one mode: solves (sum_i c_i A^i) x = b, where A^i are the operator's parts on that
/// mode. Storage is allocated once; diagonal and dense modes then solve without allocation (for sizes at
/// which Eigen's products need no heap), sparse ones reuse the symbolic analysis.
class ModeSystem {
 public:
  ModeSystem(const SeparatedOperator& a, int mode);

  /// @returns false if the matrix is singular to working precision or the solution is not finite.
  bool solve(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs, Eigen::Ref<Eigen::VectorXd> x);

 private:
  bool solve_diagonal(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs,
                      Eigen::Ref<Eigen::VectorXd> x);
  bool solve_dense(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs,
                   Eigen::Ref<Eigen::VectorXd> x);
  bool solve_sparse(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs,
                    Eigen::Ref<Eigen::VectorXd> x);

  const SeparatedOperator& a_;
  std::size_t mode_;
  ModeOperator::Structure structure_;
  Eigen::VectorXd diagonal_;
  Eigen::MatrixXd matrix_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  SparseMatrix pattern_;                        ///< union of all parts
  std::vector<Eigen::VectorXd> sparse_values_;  ///< each part on that pattern
  std::unique_ptr<Eigen::SparseLU<SparseMatrix>> sparse_lu_;
};

/// Solves sum_i A^i X C_i^T = B for the whole factor matrix X (size x terms) of one mode; C_i: terms x terms.
/// Diagonal parts decouple the nodes, sparse and dense ones give one system of size * terms unknowns.
/// @returns false if the system is singular to working precision; X is then unchanged.
bool solve_factor_system(const SeparatedOperator& a, int mode, std::span<const Eigen::MatrixXd> c,
                         const Eigen::MatrixXd& b, Eigen::MatrixXd& x);

}  // namespace samara::pgd
