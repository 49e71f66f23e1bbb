#include "samara/identification/solve/secant_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Cholesky>

namespace samara::identification {

namespace {

/// Of J^T W J: where a step shows more, the cost is not smooth on its scale, and nothing is to be learned.
constexpr double kMostLack = 1.0;

/// sqrt(v^T M^-1 v)
double size_against(const Eigen::MatrixXd& M, const Eigen::VectorXd& v) {
  std::vector<int> all(static_cast<std::size_t>(v.size()));
  std::iota(all.begin(), all.end(), 0);
  const auto solved = damped_step(M, damping_scale(M), v, all, 1e-12);
  return solved ? std::sqrt(std::max(0.0, -v.dot(*solved))) : 0.0;
}

}  // namespace

void SecantModel::move_to(Eigen::MatrixXd normal) {
  normal_ = std::move(normal);
  if (learned_.rows() != normal_.rows()) learned_.setZero(normal_.rows(), normal_.cols());
}

void SecantModel::learn(const Eigen::VectorXd& step, const Eigen::VectorXd& change) {
  constexpr double kOrthogonal = 1e-8;
  const Eigen::VectorXd lack = change - normal_ * step;
  if (size_against(normal_, lack) > kMostLack * std::sqrt(std::max(step.dot(normal_ * step), 0.0))) {
    forget();
    return;
  }
  const double known = step.dot(learned_ * step);
  // What was learned elsewhere may be too large here: no larger than what is seen now.
  if (known != 0.0) learned_ *= std::min(1.0, std::abs(step.dot(lack) / known));
  Eigen::VectorXd v = change;
  if (!(v.dot(step) > kOrthogonal * v.norm() * step.norm())) v = normal_ * step;
  const double along = v.dot(step);
  if (!(along > kOrthogonal * v.norm() * step.norm())) return;
  const Eigen::VectorXd rest = (lack - learned_ * step) / along;
  learned_ += rest * v.transpose() + v * rest.transpose() - (step.dot(rest) / along) * v * v.transpose();
  if (!learned_.allFinite()) forget();
}

std::optional<Eigen::VectorXd> damped_step(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& diagonal,
                                           const Eigen::VectorXd& gradient, const std::vector<int>& free,
                                           double damping) {
  const Eigen::VectorXd scale = diagonal(free).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd damped = scale.asDiagonal() * matrix(free, free) * scale.asDiagonal();
  damped.diagonal().array() += damping;
  const Eigen::LLT<Eigen::MatrixXd> factor(damped);
  if (factor.info() != Eigen::Success) return {};
  Eigen::VectorXd step = Eigen::VectorXd::Zero(gradient.size());
  const Eigen::VectorXd scaled = scale.cwiseProduct(gradient(free));
  step(free) = -scale.cwiseProduct(factor.solve(scaled));
  if (!step.allFinite()) return {};
  return step;
}

Eigen::VectorXd damping_scale(const Eigen::MatrixXd& normal) {
  constexpr double kLeast = 1e-14;
  const Eigen::VectorXd diagonal = normal.diagonal();
  const double largest = diagonal.size() > 0 ? diagonal.maxCoeff() : 0.0;
  return largest > 0.0 ? Eigen::VectorXd(diagonal.cwiseMax(kLeast * largest))
                       : Eigen::VectorXd::Ones(diagonal.size()).eval();
}

}  // namespace samara::identification
