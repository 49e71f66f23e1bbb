#include "samara/models/added_mass/panel_gmres.h"

#include <algorithm>
#include <array>
#include <vector>

#include <Eigen/Jacobi>

#include "samara/base/parallel.h"
#include "samara/models/added_mass/panel_kernels.h"

namespace samara::models::added_mass {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of a matrix, to one task.
constexpr std::size_t kProductRows = 128;

/// S A S x for up to kColumns columns, S = diag(A)^(-1/2).
class ScaledOperator {
 public:
  explicit ScaledOperator(const RowMajorMatrix& A)
      : A_(A),
        scale_(A.diagonal().cwiseAbs().cwiseSqrt().cwiseInverse()),
        in_(A.rows(), kColumns),
        out_(A.rows(), kColumns) {
    in_.setZero();
  }
  const VectorXd& scale() const { return scale_; }

  auto set_column(Index c, const VectorXd& x) { in_.col(c) = scale_.cwiseProduct(x); }
  void apply() {
    const auto n = static_cast<std::size_t>(A_.rows());
    parallel_for((n + kProductRows - 1) / kProductRows, [&](std::size_t rows) {
      multiply_rows(A_.data(), n, rows * kProductRows, std::min(n, (rows + 1) * kProductRows), in_.data(),
                    out_.data());
    });
  }
  VectorXd column(Index c) const { return scale_.cwiseProduct(out_.col(c)); }

 private:
  const RowMajorMatrix& A_;
  VectorXd scale_;
  Eigen::Matrix<double, Eigen::Dynamic, static_cast<int>(kColumns), Eigen::RowMajor> in_, out_;
};

/// The Krylov space of one right-hand side, its Hessenberg matrix made triangular by rotations as it grows.
class KrylovSpace {
 public:
  KrylovSpace(const VectorXd& b, int max_iterations)
      : norm_(b.norm()),
        H_(MatrixXd::Zero(max_iterations + 1, max_iterations)),
        g_(VectorXd::Zero(max_iterations + 1)) {
    g_[0] = norm_;
    basis_.push_back(norm_ > 0.0 ? VectorXd(b / norm_) : VectorXd(b));
  }

  bool solved(double tolerance) const { return exact_ || std::abs(g_[size_]) <= tolerance * norm_; }
  const VectorXd& last() const { return basis_.back(); }

  void extend(VectorXd w) {
    const Index k = size_;
    const double before = w.norm();
    for (int pass = 0; pass < 2; ++pass) {  // twice is enough for orthogonality to round-off
      for (Index i = 0; i <= k; ++i) {
        const double h = basis_[static_cast<std::size_t>(i)].dot(w);
        H_(i, k) += h;
        w -= h * basis_[static_cast<std::size_t>(i)];
      }
    }
    H_(k + 1, k) = w.norm();
    exact_ = H_(k + 1, k) <= 1e-15 * before;
    basis_.push_back(exact_ ? w : VectorXd(w / H_(k + 1, k)));
    for (Index i = 0; i < k; ++i) {
      H_.col(k).applyOnTheLeft(i, i + 1, rotations_[static_cast<std::size_t>(i)].adjoint());
    }
    Eigen::JacobiRotation<double> rotation;
    rotation.makeGivens(H_(k, k), H_(k + 1, k));
    H_.col(k).applyOnTheLeft(k, k + 1, rotation.adjoint());
    g_.applyOnTheLeft(k, k + 1, rotation.adjoint());
    rotations_.push_back(rotation);
    ++size_;
  }

  VectorXd solution() const {
    VectorXd x = VectorXd::Zero(basis_.front().size());
    if (size_ == 0) return x;
    const VectorXd y = H_.topLeftCorner(size_, size_).triangularView<Eigen::Upper>().solve(g_.head(size_));
    for (Index i = 0; i < size_; ++i) x += y[i] * basis_[static_cast<std::size_t>(i)];
    return x;
  }

 private:
  double norm_;
  bool exact_ = false;  ///< the space cannot grow: it holds the solution
  Index size_ = 0;
  MatrixXd H_;
  VectorXd g_;
  std::vector<VectorXd> basis_;
  std::vector<Eigen::JacobiRotation<double>> rotations_;
};

}  // namespace

GmresOutcome gmres(const RowMajorMatrix& A, const SixColumns& b, double tolerance, int max_iterations,
                   SharedProgress& progress, SixColumns& x) {
  ScaledOperator scaled(A);
  std::vector<KrylovSpace> spaces;
  for (Index c = 0; c < 6; ++c) spaces.emplace_back(scaled.scale().cwiseProduct(b.col(c)), max_iterations);
  const auto all_solved = [&] {
    return std::all_of(spaces.begin(), spaces.end(),
                       [&](const KrylovSpace& s) { return s.solved(tolerance); });
  };
  GmresOutcome outcome;
  while (!(outcome.converged = all_solved()) && outcome.iterations < max_iterations && progress.goes_on()) {
    for (Index c = 0; c < 6; ++c) scaled.set_column(c, spaces[static_cast<std::size_t>(c)].last());
    scaled.apply();
    for (Index c = 0; c < 6; ++c) {
      KrylovSpace& space = spaces[static_cast<std::size_t>(c)];
      if (!space.solved(tolerance)) space.extend(scaled.column(c));
    }
    ++outcome.iterations;
    progress.count();
  }
  x.resize(b.rows(), 6);
  for (Index c = 0; c < 6; ++c) {
    x.col(c) = scaled.scale().cwiseProduct(spaces[static_cast<std::size_t>(c)].solution());
  }
  return outcome;
}

}  // namespace samara::models::added_mass
