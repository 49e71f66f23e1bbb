#include "samara/pgd/sparse_solver.h"

#include <array>
#include <utility>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#ifdef SAMARA_HAS_SUITESPARSE
#include <Eigen/CholmodSupport>
#include <Eigen/UmfPackSupport>
#endif

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::pgd {

namespace {

constexpr std::array kNames = {"automatic", "eigen_ldlt", "eigen_lu", "cholmod", "umfpack"};

bool is_symmetric(const SparseMatrix& matrix) {
  const SparseMatrix difference = matrix - SparseMatrix(matrix.transpose());
  const double size = matrix.coeffs().cwiseAbs().maxCoeff();
  return difference.nonZeros() == 0 || difference.coeffs().cwiseAbs().maxCoeff() <= 1e-13 * size;
}

/// Any of the solvers with Eigen's interface.
template <class Solver>
class Direct final : public SparseSolver {
 public:
  explicit Direct(const SparseMatrix& pattern) { solver_.analyzePattern(pattern); }

  bool factorize(const SparseMatrix& matrix) override {
    solver_.factorize(matrix);
    return solver_.info() == Eigen::Success;
  }

  bool solve(const Eigen::MatrixXd& b, Eigen::Ref<Eigen::MatrixXd> x) override {
    x = solver_.solve(b);
    return solver_.info() == Eigen::Success && x.allFinite();
  }

 private:
  Solver solver_;
};

using Ldlt = Direct<Eigen::SimplicialLDLT<SparseMatrix>>;
using Lu = Direct<Eigen::SparseLU<SparseMatrix>>;

/// LDL^T where it holds. It does not pivot, so its answers are checked.
class Automatic final : public SparseSolver {
 public:
  explicit Automatic(SparseMatrix pattern) : pattern_(std::move(pattern)) {}

  bool factorize(const SparseMatrix& matrix) override {
    use_ldlt_ = is_symmetric(matrix);
    if (use_ldlt_) {
      if (!ldlt_) ldlt_ = std::make_unique<Ldlt>(pattern_);
      use_ldlt_ = ldlt_->factorize(matrix);
      if (use_ldlt_) matrix_ = matrix;
    }
    return use_ldlt_ || factorize_lu(matrix);
  }

  bool solve(const Eigen::MatrixXd& b, Eigen::Ref<Eigen::MatrixXd> x) override {
    constexpr double kAcceptable = 1e-8;
    if (use_ldlt_) {
      const bool solved = ldlt_->solve(b, x);
      if (solved && (matrix_ * x - b).norm() <= kAcceptable * b.norm()) return true;
      use_ldlt_ = false;
      if (!factorize_lu(matrix_)) return false;
    }
    return lu_->solve(b, x);
  }

 private:
  bool factorize_lu(const SparseMatrix& matrix) {
    if (!lu_) lu_ = std::make_unique<Lu>(pattern_);
    return lu_->factorize(matrix);
  }

  SparseMatrix pattern_;
  SparseMatrix matrix_;
  std::unique_ptr<Ldlt> ldlt_;
  std::unique_ptr<Lu> lu_;
  bool use_ldlt_ = false;
};

}  // namespace

std::string to_string(SparseSolverKind kind) {
  return kNames.at(static_cast<std::size_t>(kind));
}

bool is_available(SparseSolverKind kind) {
#ifdef SAMARA_HAS_SUITESPARSE
  static_cast<void>(kind);
  return true;
#else
  return kind != SparseSolverKind::cholmod && kind != SparseSolverKind::umfpack;
#endif
}

std::unique_ptr<SparseSolver> make_sparse_solver(SparseSolverKind kind, const SparseMatrix& pattern) {
  switch (kind) {
    case SparseSolverKind::automatic:
      return std::make_unique<Automatic>(pattern);
    case SparseSolverKind::eigen_ldlt:
      return std::make_unique<Ldlt>(pattern);
    case SparseSolverKind::eigen_lu:
      return std::make_unique<Lu>(pattern);
#ifdef SAMARA_HAS_SUITESPARSE
    case SparseSolverKind::cholmod:
      return std::make_unique<Direct<Eigen::CholmodDecomposition<SparseMatrix>>>(pattern);
    case SparseSolverKind::umfpack:
      return std::make_unique<Direct<Eigen::UmfPackLU<SparseMatrix>>>(pattern);
#endif
    default:
      break;
  }
  throw ArgumentError(
      fmt::format("the sparse solver \"{}\" is not in this build, expected one with SAMARA_SUITESPARSE",
                  to_string(kind)));
}

}  // namespace samara::pgd
