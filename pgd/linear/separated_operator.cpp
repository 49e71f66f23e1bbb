#include "samara/pgd/linear/separated_operator.h"

#include <algorithm>
#include <functional>
#include <string_view>
#include <type_traits>
#include <utility>

namespace samara::pgd {

namespace {
template <class... Handlers>
struct Overloaded : Handlers... {
  using Handlers::operator()...;
};
template <class... Handlers>
Overloaded(Handlers...) -> Overloaded<Handlers...>;

SparseMatrix sparse_diagonal(const Eigen::VectorXd& values) {
  SparseMatrix matrix(values.size(), values.size());
  matrix.reserve(Eigen::VectorXi::Ones(values.size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) matrix.insert(i, i) = values[i];
  return matrix;
}
}  // namespace

int ModeOperator::rows() const {
  return std::visit(
      Overloaded{[](int n) { return n; }, [](const auto& m) { return static_cast<int>(m.rows()); }},
      storage_);
}

int ModeOperator::cols() const {
  return std::visit(
      Overloaded{[](int n) { return n; }, [](const Eigen::VectorXd& d) { return static_cast<int>(d.size()); },
                 [](const auto& m) { return static_cast<int>(m.cols()); }},
      storage_);
}

ModeOperator::Structure ModeOperator::structure() const {
  if (std::holds_alternative<SparseMatrix>(storage_)) return Structure::sparse;
  if (std::holds_alternative<Eigen::MatrixXd>(storage_)) return Structure::dense;
  return Structure::diagonal;
}

Eigen::MatrixXd ModeOperator::apply(const Eigen::MatrixXd& x) const {
  return std::visit(
      Overloaded{[&](int) -> Eigen::MatrixXd { return x; },
                 [&](const Eigen::VectorXd& d) -> Eigen::MatrixXd { return d.asDiagonal() * x; },
                 [&](const auto& m) -> Eigen::MatrixXd { return m * x; }},
      storage_);
}

Eigen::MatrixXd ModeOperator::apply_magnitudes(const Eigen::MatrixXd& x) const {
  const Eigen::MatrixXd sizes = x.cwiseAbs();
  return std::visit(Overloaded{[&](int) -> Eigen::MatrixXd { return sizes; },
                               [&](const Eigen::VectorXd& d) -> Eigen::MatrixXd {
                                 return d.cwiseAbs().asDiagonal() * sizes;
                               },
                               [&](const auto& m) -> Eigen::MatrixXd { return m.cwiseAbs() * sizes; }},
                    storage_);
}

double ModeOperator::largest() const {
  return std::visit(Overloaded{[](int) { return 1.0; },
                               [](const SparseMatrix& m) {
                                 return m.nonZeros() == 0 ? 0.0 : m.coeffs().cwiseAbs().maxCoeff();
                               },
                               [](const auto& m) { return m.size() == 0 ? 0.0 : m.cwiseAbs().maxCoeff(); }},
                    storage_);
}

void ModeOperator::apply_to(Eigen::Ref<const Eigen::VectorXd> x, Eigen::Ref<Eigen::VectorXd> y) const {
  std::visit(Overloaded{[&](int) { y = x; }, [&](const Eigen::VectorXd& d) { y = d.cwiseProduct(x); },
                        [&](const auto& m) { y.noalias() = m * x; }},
             storage_);
}

void ModeOperator::add_to_diagonal(Eigen::Ref<Eigen::VectorXd> target, double scale) const {
  if (const auto* d = std::get_if<Eigen::VectorXd>(&storage_)) {
    target += scale * *d;
  } else {
    target.array() += scale;
  }
}

void ModeOperator::add_to_dense(Eigen::Ref<Eigen::MatrixXd> target, double scale) const {
  std::visit(Overloaded{[&](int) { target.diagonal().array() += scale; },
                        [&](const Eigen::VectorXd& d) { target.diagonal() += scale * d; },
                        [&](const auto& m) { target += scale * m; }},
             storage_);
}

void ModeOperator::add_to_triplets(std::vector<Eigen::Triplet<double>>& target, int row, int col,
                                   double scale) const {
  const SparseMatrix matrix = as_sparse();
  for (int outer = 0; outer < matrix.outerSize(); ++outer) {
    for (SparseMatrix::InnerIterator it(matrix, outer); it; ++it) {
      target.emplace_back(row + static_cast<int>(it.row()), col + static_cast<int>(it.col()),
                          scale * it.value());
    }
  }
}

bool ModeOperator::all_finite() const {
  return std::visit(
      Overloaded{[](int) { return true; },
                 [](const SparseMatrix& m) {
                   return Eigen::Map<const Eigen::VectorXd>(m.valuePtr(), m.nonZeros()).allFinite();
                 },
                 [](const auto& m) { return m.allFinite(); }},
      storage_);
}

bool ModeOperator::operator==(const ModeOperator& other) const {
  if (storage_.index() != other.storage_.index() || rows() != other.rows() || cols() != other.cols())
    return false;
  return std::visit(
      Overloaded{
          [](int) { return true; },
          [&](const SparseMatrix& m) {
            const auto& o = std::get<SparseMatrix>(other.storage_);
            return m.nonZeros() == o.nonZeros() &&
                   std::equal(m.valuePtr(), m.valuePtr() + m.nonZeros(), o.valuePtr()) &&
                   std::equal(m.innerIndexPtr(), m.innerIndexPtr() + m.nonZeros(), o.innerIndexPtr()) &&
                   std::equal(m.outerIndexPtr(), m.outerIndexPtr() + m.outerSize() + 1, o.outerIndexPtr());
          },
          [&](const auto& m) { return m == std::get<std::decay_t<decltype(m)>>(other.storage_); }},
      storage_);
}

std::size_t ModeOperator::fingerprint() const {
  const auto of_numbers = [this](const double* values, Eigen::Index count) {
    const std::string_view bytes(reinterpret_cast<const char*>(values),
                                 static_cast<std::size_t>(count) * sizeof(double));
    return std::hash<std::string_view>()(bytes) ^ (storage_.index() + static_cast<std::size_t>(rows()) * 4);
  };
  return std::visit(Overloaded{[&](int) { return of_numbers(nullptr, 0); },
                               [&](const SparseMatrix& m) { return of_numbers(m.valuePtr(), m.nonZeros()); },
                               [&](const auto& m) { return of_numbers(m.data(), m.size()); }},
                    storage_);
}

SparseMatrix ModeOperator::as_sparse() const {
  return std::visit(
      Overloaded{[](int n) { return sparse_diagonal(Eigen::VectorXd::Ones(n)); },
                 [](const Eigen::VectorXd& d) { return sparse_diagonal(d); },
                 [](const SparseMatrix& m) { return m; },
                 [](const Eigen::MatrixXd& m) -> SparseMatrix { return m.sparseView(0.0, 0.0); }},
      storage_);
}

Eigen::MatrixXd ModeOperator::as_dense() const {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(rows(), cols());
  add_to_dense(matrix, 1.0);
  return matrix;
}

ModeOperator ModeOperator::transposed_times(const Eigen::VectorXd& weights, const ModeOperator& other) const {
  const Structure result = std::max(structure(), other.structure());
  const ModeOperator right = other.row_scaled(weights);
  if (result == Structure::diagonal) {
    Eigen::VectorXd left = Eigen::VectorXd::Zero(rows());
    Eigen::VectorXd values = Eigen::VectorXd::Zero(rows());
    add_to_diagonal(left, 1.0);
    right.add_to_diagonal(values, 1.0);
    return diagonal(left.cwiseProduct(values));
  }
  if (result == Structure::sparse) return sparse(SparseMatrix(as_sparse().transpose() * right.as_sparse()));
  return dense(as_dense().transpose() * right.as_dense());
}

ModeOperator ModeOperator::row_scaled(const Eigen::VectorXd& weights) const {
  if (weights.size() == 0) return *this;
  return std::visit(
      Overloaded{[&](int) { return diagonal(weights); },
                 [&](const Eigen::VectorXd& d) { return diagonal(weights.cwiseProduct(d)); },
                 [&](const SparseMatrix& m) { return sparse(SparseMatrix(weights.asDiagonal() * m)); },
                 [&](const Eigen::MatrixXd& m) { return dense(weights.asDiagonal() * m); }},
      storage_);
}

SeparatedTensor SeparatedOperator::apply(const SeparatedTensor& u) const {
  SeparatedTensor result;
  const Eigen::Index r = u.rank();
  result.weights.resize(r * rank());
  for (int k = 0; k < modes(); ++k) {
    const auto mode = static_cast<std::size_t>(k);
    result.factors.emplace_back(terms.front()[mode].rows(), r * rank());
    for (std::size_t i = 0; i < terms.size(); ++i) {
      result.factors[mode].middleCols(static_cast<Eigen::Index>(i) * r, r) =
          terms[i][mode].apply(u.factors[mode]);
    }
  }
  for (Eigen::Index i = 0; i < rank(); ++i) result.weights.segment(i * r, r) = u.weights;
  return result;
}

}  // namespace samara::pgd
