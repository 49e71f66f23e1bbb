#pragma once

#include <memory>
#include <string>

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"

namespace samara::pgd {

/// Who factorises the sparse matrices of an axis. The SuiteSparse ones exist if the library was built with
/// them (CMake option SAMARA_SUITESPARSE); UMFPACK and parts of CHOLMOD are under the GPL.
enum class SparseSolverKind {
  /// Symmetric matrices: Eigen's LDL^T or, where a factorisation takes long, CHOLMOD, checked and replaced by LU if
  /// they break down. Others: Eigen's LU or, where the factors of large matrices fill, UMFPACK. The bounds, which
  /// stand in sparse_solver.cpp, are where these win on meshes and on the block systems of factor updates.
  automatic,
  eigen_ldlt,  ///< Eigen's simplicial LDL^T; symmetric matrices only
  eigen_lu,    ///< Eigen's supernodal LU
  cholmod,     ///< CHOLMOD, simplicial or supernodal; symmetric matrices only
  umfpack,     ///< UMFPACK's multifrontal LU
};

/// "automatic", "eigen_ldlt", "eigen_lu", "cholmod", "umfpack"
std::string to_string(SparseSolverKind kind);
/// Whether this build of the library has it.
bool is_available(SparseSolverKind kind);

/// Direct solution of sparse systems that share a pattern.
class SparseSolver {
 public:
  virtual ~SparseSolver() = default;
  /// The matrix must stay where it is until the last solve() with it.
  /// @returns false if the matrix is singular, or not of the kind that the solver takes.
  virtual bool factorize(const SparseMatrix& matrix) = 0;
  /// x = matrix^-1 b, columns at once. @returns false if x is not finite.
  virtual bool solve(const Eigen::MatrixXd& b, Eigen::Ref<Eigen::MatrixXd> x) = 0;
  /// Who holds the factors; of the automatic one, the kind that it took.
  virtual SparseSolverKind kind() const = 0;
};

/// @param pattern a matrix with the pattern of those to come
/// @throws ArgumentError if the kind is not available.
std::unique_ptr<SparseSolver> make_sparse_solver(SparseSolverKind kind, const SparseMatrix& pattern);

}  // namespace samara::pgd
