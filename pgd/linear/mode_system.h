#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include "samara/pgd/linear/operator_chain.h"
#include "samara/pgd/linear/separated_operator.h"
#include "samara/pgd/linear/sparse_solver.h"

namespace samara::pgd {

/// The least structure that holds a sum of the parts.
ModeOperator::Structure sum_structure(const std::vector<ModeOperator>& parts);

/// sum_p coefficients[p] parts[p]; the pattern is that of all parts, whatever the coefficients.
SparseMatrix sparse_sum(const std::vector<ModeOperator>& parts, const Eigen::VectorXd& coefficients);

/// Whether a solution of this norm may be that of a regular system: of a singular one, solved to working
/// precision, it is beyond 1e14 times what right-hand side and matrix (its largest entry) suggest.
bool is_plausible(double largest_entry, double rhs_norm, double solution_norm);

/// The 1-D problems of one mode: solves (sum_p c_p A^p) x = b, where A^p are the operator's distinct parts on
/// that mode. Storage is allocated once; diagonal and dense modes then solve without allocation (for sizes at
/// which Eigen's products need no heap), sparse ones reuse the symbolic analysis.
class ModeSystem {
 public:
  /// The parts must outlive it.
  ModeSystem(const std::vector<ModeOperator>& parts, SparseSolverKind kind);

  ModeOperator::Structure structure() const { return structure_; }
  const std::vector<ModeOperator>& parts() const { return *parts_; }

  /// @returns false if the matrix is singular to working precision or the solution is not finite.
  bool solve(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs, Eigen::Ref<Eigen::VectorXd> x);

 private:
  bool solve_diagonal(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs,
                      Eigen::Ref<Eigen::VectorXd> x);
  bool solve_dense(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs,
                   Eigen::Ref<Eigen::VectorXd> x);
  bool solve_sparse(const Eigen::VectorXd& coefficients, const Eigen::VectorXd& rhs,
                    Eigen::Ref<Eigen::VectorXd> x);

  const std::vector<ModeOperator>* parts_;
  ModeOperator::Structure structure_;
  Eigen::VectorXd diagonal_;
  Eigen::MatrixXd matrix_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  SparseMatrix pattern_;                        ///< of all parts together
  std::vector<Eigen::VectorXd> sparse_values_;  ///< each part on that pattern
  std::unique_ptr<SparseSolver> sparse_;
};

/// One for every mode of the chain, which must outlive them.
std::vector<ModeSystem> make_mode_systems(const OperatorChain& chain, SparseSolverKind kind);

}  // namespace samara::pgd
