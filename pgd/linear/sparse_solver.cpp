#include "samara/pgd/linear/sparse_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
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
template <class Solver, SparseSolverKind kKind, bool kSymmetricOnly>
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

  SparseSolverKind kind() const override { return kKind; }
  const Solver& solver() const { return solver_; }

 private:
  Solver solver_;
  SymmetryTest is_symmetric_;
};

/// Eigen's LDL^T, which knows from its analysis what a factorisation takes.
class CountedLdlt : public Eigen::SimplicialLDLT<SparseMatrix> {
 public:
  double factor_entries() const { return m_nonZerosPerCol.cast<double>().sum(); }
  double multiplications() const { return m_nonZerosPerCol.cast<double>().squaredNorm(); }
};

using Ldlt = Direct<CountedLdlt, SparseSolverKind::eigen_ldlt, true>;
using Lu = Direct<Eigen::SparseLU<SparseMatrix>, SparseSolverKind::eigen_lu, false>;

/// Dense blocks pay where columns of the factor are long, and the matrix is large enough to have many of them.
/// Measured (the case solver_sizes of the benchmark linear_engine): on planes of 200^2 nodes, solids of 15^3 and 8 by
/// 30^2 nodes in blocks both take about as long; below, CHOLMOD takes up to three times as long, and beyond, LDL^T.
bool pays_cholmod(const CountedLdlt& analysed) {
  constexpr double kMultiplications = 2e8, kPerEntry = 180.0;
  const double work = analysed.multiplications();
  return is_available(SparseSolverKind::cholmod) && work >= kMultiplications &&
         work >= kPerEntry * analysed.factor_entries();
}

/// UMFPACK takes half the time of Eigen's LU on meshes, and up to three times as long where the band is full, as that
/// of time elements is: nothing fills there.
bool pays_umfpack(const SparseMatrix& pattern) {
  constexpr double kLarge = 12'000.0, kFullBand = 0.25;
  Eigen::Index reach = 0;
  for (int column = 0; column < pattern.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator entry(pattern, column); entry; ++entry)
      reach = std::max(reach, std::abs(entry.row() - entry.col()));
  }
  const auto entries = static_cast<double>(pattern.nonZeros());
  const double band = static_cast<double>(pattern.rows()) * static_cast<double>(2 * reach + 1);
  return is_available(SparseSolverKind::umfpack) && entries >= kLarge && entries < kFullBand * band;
}

/// One after the other, until one holds. What does not pivot has its answers checked.
class Automatic final : public SparseSolver {
 public:
  explicit Automatic(SparseMatrix pattern) : pattern_(std::move(pattern)), is_symmetric_(pattern_) {}

  bool factorize(const SparseMatrix& matrix) override {
    matrix_ = &matrix;
    used_ = nullptr;
    if (is_symmetric_(matrix)) {
      prepare_symmetric();
      // One that is not definite is not likely to be followed by others that are.
      if (cholmod_ && !cholmod_->factorize(matrix)) cholmod_.reset();
      used_ = cholmod_.get();
      if (!used_) {
        prepare_ldlt();
        if (ldlt_->factorize(matrix)) used_ = ldlt_.get();
      }
    }
    return used_ != nullptr || factorize_lu(matrix);
  }

  bool solve(const Eigen::MatrixXd& b, Eigen::Ref<Eigen::MatrixXd> x) override {
    if (used_ != lu_.get()) {
      if (used_->solve(b, x) && is_backward_stable(b, x)) return true;
      if (!factorize_lu(*matrix_)) return false;
    }
    return lu_->solve(b, x);
  }

  SparseSolverKind kind() const override {
    return used_ == nullptr ? SparseSolverKind::automatic : used_->kind();
  }

 private:
  /// Whether x solves a system close to the one asked for.
  bool is_backward_stable(const Eigen::MatrixXd& b, const Eigen::MatrixXd& x) const {
    constexpr double kAcceptable = 1e-11;
    double largest = 0.0;  // coeffs() has gaps of matrices that are not compressed
    for (Eigen::Index column = 0; column < matrix_->outerSize(); ++column)
      for (SparseMatrix::InnerIterator entry(*matrix_, column); entry; ++entry)
        largest = std::max(largest, std::abs(entry.value()));
    const double size = largest * x.norm() + b.norm();
    return (*matrix_ * x - b).norm() <= kAcceptable * size;
  }

  void prepare_ldlt() {
    if (!ldlt_) ldlt_ = std::make_unique<Ldlt>(pattern_);
  }

  /// The analysis of LDL^T tells who factorises.
  void prepare_symmetric() {
    if (ldlt_ || cholmod_) return;
    prepare_ldlt();
    if (!pays_cholmod(ldlt_->solver())) return;
    cholmod_ = make_sparse_solver(SparseSolverKind::cholmod, pattern_);
    ldlt_.reset();
  }

  bool factorize_lu(const SparseMatrix& matrix) {
    if (!lu_) {
      lu_ = make_sparse_solver(
          pays_umfpack(pattern_) ? SparseSolverKind::umfpack : SparseSolverKind::eigen_lu, pattern_);
    }
    used_ = lu_.get();
    return lu_->factorize(matrix);
  }

  SparseMatrix pattern_;
  SymmetryTest is_symmetric_;
  const SparseMatrix* matrix_ = nullptr;  ///< factorised last
  std::unique_ptr<SparseSolver> cholmod_;
  std::unique_ptr<Ldlt> ldlt_;
  std::unique_ptr<SparseSolver> lu_;
  SparseSolver* used_ = nullptr;  ///< by the last factorisation; null before
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
      return std::make_unique<
          Direct<Eigen::CholmodDecomposition<SparseMatrix>, SparseSolverKind::cholmod, true>>(pattern);
    case SparseSolverKind::umfpack:
      return std::make_unique<Direct<Eigen::UmfPackLU<SparseMatrix>, SparseSolverKind::umfpack, false>>(
          pattern);
#endif
    default:
      break;
  }
  throw ArgumentError(
      fmt::format("the sparse solver \"{}\" is not in this build, expected one with SAMARA_SUITESPARSE",
                  to_string(kind)));
}

}  // namespace samara::pgd
