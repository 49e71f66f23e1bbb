#include "samara/pgd/linear/sparse_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

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

/// For every stored value of a matrix of this pattern the place of the one mirrored at the diagonal; empty if
/// one is not stored.
std::vector<Eigen::Index> mirrored_places(const SparseMatrix& pattern) {
  std::vector<Eigen::Index> places;
  places.reserve(static_cast<std::size_t>(pattern.nonZeros()));
  const int* outer = pattern.outerIndexPtr();
  const int* inner = pattern.innerIndexPtr();
  for (int col = 0; col < pattern.outerSize(); ++col) {
    for (int at = outer[col]; at < outer[col + 1]; ++at) {
      const int* end = inner + outer[inner[at] + 1];
      const int* found = std::lower_bound(inner + outer[inner[at]], end, col);
      if (found == end || *found != col) return {};
      places.push_back(found - inner);
    }
  }
  return places;
}

/// Whether a matrix of a known pattern is symmetric.
class SymmetryTest {
 public:
  explicit SymmetryTest(const SparseMatrix& pattern) : mirrored_(mirrored_places(pattern)) {}

  bool operator()(const SparseMatrix& matrix) const {
    if (mirrored_.size() != static_cast<std::size_t>(matrix.nonZeros())) return false;
    const double* values = matrix.valuePtr();
    double size = 0.0;
    double difference = 0.0;
    for (std::size_t i = 0; i < mirrored_.size(); ++i) {
      size = std::max(size, std::abs(values[i]));
      difference = std::max(difference, std::abs(values[i] - values[mirrored_[i]]));
    }
    return difference <= 1e-13 * size;
  }

 private:
  std::vector<Eigen::Index> mirrored_;
};

/// Any of the solvers with Eigen's interface.
template <class Solver, bool kSymmetricOnly>
class Direct final : public SparseSolver {
 public:
  explicit Direct(const SparseMatrix& pattern) : is_symmetric_(pattern) {
    if constexpr (requires { solver_.cholmod(); }) solver_.cholmod().print = 0;  // its status says it too
    solver_.analyzePattern(pattern);
  }

  bool factorize(const SparseMatrix& matrix) override {
    if (kSymmetricOnly && !is_symmetric_(matrix)) return false;
    solver_.factorize(matrix);
    return solver_.info() == Eigen::Success;
  }

  bool solve(const Eigen::MatrixXd& b, Eigen::Ref<Eigen::MatrixXd> x) override {
    x = solver_.solve(b);
    return solver_.info() == Eigen::Success && x.allFinite();
  }

 private:
  Solver solver_;
  SymmetryTest is_symmetric_;
};

using Ldlt = Direct<Eigen::SimplicialLDLT<SparseMatrix>, true>;
using Lu = Direct<Eigen::SparseLU<SparseMatrix>, false>;

/// LDL^T where it holds. It does not pivot, so its answers are checked.
class Automatic final : public SparseSolver {
 public:
  explicit Automatic(SparseMatrix pattern) : pattern_(std::move(pattern)), is_symmetric_(pattern_) {}

  bool factorize(const SparseMatrix& matrix) override {
    matrix_ = &matrix;
    use_ldlt_ = is_symmetric_(matrix);
    if (use_ldlt_) {
      if (!ldlt_) ldlt_ = std::make_unique<Ldlt>(pattern_);
      use_ldlt_ = ldlt_->factorize(matrix);
    }
    return use_ldlt_ || factorize_lu(matrix);
  }

  bool solve(const Eigen::MatrixXd& b, Eigen::Ref<Eigen::MatrixXd> x) override {
    if (use_ldlt_) {
      if (ldlt_->solve(b, x) && is_backward_stable(b, x)) return true;
      use_ldlt_ = false;
      if (!factorize_lu(*matrix_)) return false;
    }
    return lu_->solve(b, x);
  }

 private:
  /// Whether x solves a system close to the one asked for.
  bool is_backward_stable(const Eigen::MatrixXd& b, const Eigen::MatrixXd& x) const {
    constexpr double kAcceptable = 1e-11;
    const double size = matrix_->coeffs().cwiseAbs().maxCoeff() * x.norm() + b.norm();
    return (*matrix_ * x - b).norm() <= kAcceptable * size;
  }

  bool factorize_lu(const SparseMatrix& matrix) {
    if (!lu_) lu_ = std::make_unique<Lu>(pattern_);
    return lu_->factorize(matrix);
  }

  SparseMatrix pattern_;
  SymmetryTest is_symmetric_;
  const SparseMatrix* matrix_ = nullptr;  ///< factorised last
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
      return std::make_unique<Direct<Eigen::CholmodDecomposition<SparseMatrix>, true>>(pattern);
    case SparseSolverKind::umfpack:
      return std::make_unique<Direct<Eigen::UmfPackLU<SparseMatrix>, false>>(pattern);
#endif
    default:
      break;
  }
  throw ArgumentError(
      fmt::format("the sparse solver \"{}\" is not in this build, expected one with SAMARA_SUITESPARSE",
                  to_string(kind)));
}

}  // namespace samara::pgd
