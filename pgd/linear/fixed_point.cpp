#include "samara/pgd/linear/fixed_point.h"

#include <algorithm>
#include <cmath>

namespace samara::pgd {

FixedPoint::FixedPoint(const ProjectedForm& form, std::vector<ModeSystem>& systems)
    : form_(form),
      plain_(OperatorChain::identity(form.b.sizes())),
      systems_(systems),
      a_(form.a, 1, 1),
      b_(plain_, 1, form.b.rank()),
      u_(form.a, 1, 0),
      weights_of_b_(form.b.weights.transpose()),
      weights_of_u_(1, 0) {
  for (int k = 0; k < form.a.modes(); ++k) {
    coefficients_.emplace_back(static_cast<Eigen::Index>(form.a.mode(k).parts.size()));
    rhs_.emplace_back(form.a.size(k));
  }
  solution_ = applied_ = before_ = step_ = rhs_;
  deflate(SeparatedTensor::zero(form.b.sizes()));
}

void FixedPoint::deflate(const SeparatedTensor& u) {
  u_ = ChainProducts(form_.a, 1, u.rank());
  weights_of_u_ = u.weights.transpose();
  applied_to_u_.clear();
  for (int k = 0; k < form_.a.modes(); ++k) {
    applied_to_u_.emplace_back();
    for (const ModeOperator& part : form_.a.mode(k).parts)
      applied_to_u_.back().push_back(part.apply(u.factors[static_cast<std::size_t>(k)]));
  }
}

void FixedPoint::refresh(int mode, const Eigen::VectorXd& factor) {
  const auto k = static_cast<std::size_t>(mode);
  const std::vector<ModeOperator>& parts = form_.a.mode(mode).parts;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    parts[p].apply_to(factor, applied_[k]);
    a_.gram(mode, static_cast<int>(p))(0, 0) = factor.dot(applied_[k]);
    u_.gram(mode, static_cast<int>(p)).row(0).noalias() = factor.transpose() * applied_to_u_[k][p];
  }
  b_.gram(mode, 0).row(0).noalias() = factor.transpose() * form_.b.factors[k];
}

void FixedPoint::start() {
  a_.start();
  b_.start(weights_of_b_);
  u_.start(weights_of_u_);
}

bool FixedPoint::solve_mode(int mode, Product& product, double& overlap) {
  const auto k = static_cast<std::size_t>(mode);
  const std::vector<Eigen::MatrixXd>& of_product = a_.coefficients(mode);
  for (std::size_t p = 0; p < of_product.size(); ++p)
    coefficients_[k][static_cast<Eigen::Index>(p)] = of_product[p](0, 0);
  rhs_[k].noalias() = form_.b.factors[k] * b_.coefficients(mode).front().row(0).transpose();
  const std::vector<Eigen::MatrixXd>& of_solution = u_.coefficients(mode);
  for (std::size_t p = 0; p < of_solution.size(); ++p)
    rhs_[k].noalias() -= applied_to_u_[k][p] * of_solution[p].row(0).transpose();
  if (!systems_[k].solve(coefficients_[k], rhs_[k], solution_[k])) {
    product.singular = true;
    return false;
  }
  product.amplitude = solution_[k].norm();
  if (product.amplitude == 0.0) return false;
  product.gain = solution_[k].dot(rhs_[k]);
  solution_[k] /= product.amplitude;
  overlap *= solution_[k].dot(product.factors[k]);
  product.factors[k].swap(solution_[k]);
  refresh(mode, product.factors[k]);
  a_.advance(mode);
  b_.advance(mode);
  u_.advance(mode);
  return true;
}

void FixedPoint::extrapolate(Product& product, bool first) {
  // Step of this iteration and how it differs from the last one, over all modes together. Factors that turned
  // round have no step.
  double along = 0.0;
  double size = 0.0;
  for (std::size_t k = 0; k < product.factors.size(); ++k)
    first = first || product.factors[k].dot(before_[k]) < 0.0;
  for (std::size_t k = 0; k < product.factors.size(); ++k) {
    // applied_ is free between iterations.
    applied_[k] = product.factors[k] - before_[k];
    if (!first) {
      const auto change = applied_[k] - step_[k];
      along += step_[k].dot(change);
      size += change.squaredNorm();
    }
    step_[k] = applied_[k];
  }
  constexpr double kLongest = 8.0;
  relaxation_ = first || size == 0.0 ? 1.0 : std::clamp(-relaxation_ * along / size, 1.0, kLongest);
  for (std::size_t k = 0; k < product.factors.size(); ++k) {
    product.factors[k] = before_[k] + relaxation_ * step_[k];
    product.factors[k].normalize();
    refresh(static_cast<int>(k), product.factors[k]);
  }
}

void FixedPoint::run(const Options& options, Product& product) {
  const int modes = form_.a.modes();
  for (int k = 0; k < modes; ++k) {
    Eigen::VectorXd& factor = product.factors[static_cast<std::size_t>(k)];
    factor.normalize();
    refresh(k, factor);
  }
  double previous = 0.0;
  relaxation_ = 1.0;
  product.converged = false;
  product.singular = false;
  for (product.iterations = 1; product.iterations <= options.max_iterations; ++product.iterations) {
    if (options.acceleration == Acceleration::aitken) {
      for (std::size_t k = 0; k < before_.size(); ++k) before_[k] = product.factors[k];
    }
    start();
    double overlap = 1.0;  // of the new product of unit factors with the one before
    for (int k = 0; k < modes; ++k) {
      if (!solve_mode(k, product, overlap)) return;
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
    const bool last = product.iterations == options.max_iterations;
    if (options.acceleration == Acceleration::aitken && !last) extrapolate(product, product.iterations == 1);
  }
  product.iterations = options.max_iterations;
}

}  // namespace samara::pgd
