#include "samara/pgd/tensors/separated_tensor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::pgd {

SeparatedTensor SeparatedTensor::zero(std::span<const int> sizes) {
  SeparatedTensor tensor;
  for (const int n : sizes) tensor.factors.emplace_back(n, 0);
  return tensor;
}

SeparatedTensor SeparatedTensor::product(std::vector<Eigen::VectorXd> columns) {
  SeparatedTensor tensor;
  tensor.weights = Eigen::VectorXd::Ones(1);
  for (Eigen::VectorXd& column : columns) tensor.factors.emplace_back(std::move(column));
  return tensor;
}

std::vector<int> SeparatedTensor::sizes() const {
  std::vector<int> n;
  for (int k = 0; k < modes(); ++k) n.push_back(size(k));
  return n;
}

void SeparatedTensor::validate(const std::string& what) const {
  if (!weights.allFinite()) throw ArgumentError(fmt::format("the {} has a weight that is not finite", what));
  for (std::size_t k = 0; k < factors.size(); ++k) {
    if (factors[k].cols() != weights.size()) {
      throw ArgumentError(fmt::format("the {} has {} weights and a factor of {} columns on mode {}", what,
                                      weights.size(), factors[k].cols(), k));
    }
    if (!factors[k].allFinite())
      throw ArgumentError(fmt::format("the {} has an entry on mode {} that is not finite", what, k));
  }
}

double SeparatedTensor::entry(std::span<const int> index) const {
  double sum = 0.0;
  for (Eigen::Index r = 0; r < weights.size(); ++r) {
    double product = weights[r];
    for (std::size_t k = 0; k < factors.size(); ++k) product *= factors[k](index[k], r);
    sum += product;
  }
  return sum;
}

void SeparatedTensor::normalise() {
  std::vector<int> alive;
  for (int r = 0; r < rank(); ++r) {
    for (Eigen::MatrixXd& factor : factors) {
      const double length = factor.col(r).norm();
      weights[r] *= length;
      if (length > 0.0) factor.col(r) /= length;
    }
    if (weights[r] != 0.0) alive.push_back(r);
  }
  if (static_cast<int>(alive.size()) < rank()) keep(alive);
}

void SeparatedTensor::append(const SeparatedTensor& other, double scale) {
  if (&other == this) return append(SeparatedTensor(other), scale);
  const Eigen::Index old_rank = weights.size();
  weights.conservativeResize(old_rank + other.weights.size());
  weights.tail(other.weights.size()) = scale * other.weights;
  for (std::size_t k = 0; k < factors.size(); ++k) {
    factors[k].conservativeResize(Eigen::NoChange, old_rank + other.weights.size());
    factors[k].rightCols(other.weights.size()) = other.factors[k];
  }
}

void SeparatedTensor::keep(std::span<const int> terms) {
  const std::vector<int> columns(terms.begin(), terms.end());
  weights = Eigen::VectorXd(weights(columns));
  for (Eigen::MatrixXd& factor : factors) factor = Eigen::MatrixXd(factor(Eigen::all, columns));
}

SeparatedTensor scaled_modes(SeparatedTensor tensor, std::span<const Eigen::VectorXd> scale) {
  for (std::size_t k = 0; k < scale.size(); ++k) {
    if (scale[k].size() > 0) tensor.factors[k].array().colwise() *= scale[k].array();
  }
  return tensor;
}

double inner(const SeparatedTensor& a, const SeparatedTensor& b) {
  if (a.rank() == 0 || b.rank() == 0) return 0.0;
  Eigen::MatrixXd products = a.weights * b.weights.transpose();
  for (std::size_t k = 0; k < a.factors.size(); ++k) {
    products.array() *= (a.factors[k].transpose() * b.factors[k]).array();
  }
  return products.sum();
}

double fast_norm(const SeparatedTensor& tensor) {
  return std::sqrt(std::max(0.0, inner(tensor, tensor)));
}

}  // namespace samara::pgd
