#include "samara/pgd/fixed_point.h"

#include <algorithm>
#include <cmath>

namespace samara::pgd {

namespace {
/// Product over all columns but one.
void product_of_others(const Eigen::MatrixXd& products, int without, Eigen::VectorXd& result) {
  for (Eigen::Index k = 0; k < products.cols(); ++k) {
    if (k != without) result.array() *= products.col(k).array();
  }
}
}  // namespace

FixedPoint::FixedPoint(const SeparatedOperator& a) : a_(a) {
  a_products_.resize(a.rank(), a.modes());
  a_coefficients_.resize(a.rank());
  systems_.reserve(static_cast<std::size_t>(a.modes()));
  for (int k = 0; k < a.modes(); ++k) {
    systems_.emplace_back(a, k);
    rhs_.emplace_back(a.size(k));
    solution_.emplace_back(a.size(k));
    applied_.emplace_back(a.size(k));
  }
}

void FixedPoint::refresh(const SeparatedTensor& b, int mode, const Eigen::VectorXd& factor) {
  const auto k = static_cast<std::size_t>(mode);
  for (std::size_t i = 0; i < a_.terms.size(); ++i) {
    a_.terms[i][k].apply_to(factor, applied_[k]);
    a_products_(static_cast<Eigen::Index>(i), mode) = factor.dot(applied_[k]);
  }
  b_products_.col(mode).noalias() = b.factors[k].transpose() * factor;
}

bool FixedPoint::solve_mode(const SeparatedTensor& b, int mode, Product& product, double& overlap) {
  const auto k = static_cast<std::size_t>(mode);
  a_coefficients_.setOnes();
  product_of_others(a_products_, mode, a_coefficients_);
  b_coefficients_ = b.weights;
  product_of_others(b_products_, mode, b_coefficients_);
  rhs_[k].noalias() = b.factors[k] * b_coefficients_;
  if (!systems_[k].solve(a_coefficients_, rhs_[k], solution_[k])) {
    product.singular = true;
    return false;
  }
  product.amplitude = solution_[k].norm();
  if (product.amplitude == 0.0) return false;
  solution_[k] /= product.amplitude;
  overlap *= solution_[k].dot(product.factors[k]);
  product.factors[k].swap(solution_[k]);
  refresh(b, mode, product.factors[k]);
  return true;
}

void FixedPoint::run(const SeparatedTensor& b, const Options& options, Product& product) {
  b_products_.resize(b.rank(), b.modes());
  b_coefficients_.resize(b.rank());
  for (int k = 0; k < b.modes(); ++k) {
    product.factors[static_cast<std::size_t>(k)].normalize();
    refresh(b, k, product.factors[static_cast<std::size_t>(k)]);
  }
  double previous = 0.0;
  product.converged = false;
  product.singular = false;
  for (product.iterations = 1; product.iterations <= options.max_iterations; ++product.iterations) {
    double overlap = 1.0;  // of the new product of unit factors with the one before
    for (int k = 0; k < b.modes(); ++k) {
      if (!solve_mode(b, k, product, overlap)) return;
    }
    // (6.13): || new - old || of the whole products.
    const double a = product.amplitude;
    const double change =
        std::sqrt(std::max(0.0, a * a + previous * previous - 2.0 * a * previous * overlap));
    previous = a;
    if (change <= options.tolerance * a) {
      product.converged = true;
      return;
    }
  }
  product.iterations = options.max_iterations;
}

}  // namespace samara::pgd
