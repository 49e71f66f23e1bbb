#include "samara/identification/solve/descent_steps.h"

#include <algorithm>

#include "samara/identification/problem/box_bounds.h"

namespace samara::identification {

void add_free(const std::vector<models::FamilyCoordinate>& box, const Chart& chart,
              const Eigen::VectorXd& values, const Eigen::Ref<const Eigen::VectorXd>& gradient, int first,
              std::vector<int>& free) {
  std::vector<char> held(static_cast<std::size_t>(chart.directions()), 0);
  const std::vector<char> at = at_bounds(box, chart, values);
  for (std::size_t k = 0; k < box.size(); ++k) {
    const int direction = chart.direction_of(static_cast<int>(k));
    if (!at[k] || direction < 0) continue;
    const double value = values[static_cast<Eigen::Index>(k)];
    const bool at_lower = value < 0.5 * (box[k].lower + box[k].upper);
    const double slope = gradient[direction];
    held[static_cast<std::size_t>(direction)] = at_lower ? slope >= 0.0 : slope <= 0.0;
  }
  for (int k = 0; k < chart.directions(); ++k) {
    if (!held[static_cast<std::size_t>(k)]) free.push_back(first + k);
  }
}

Eigen::VectorXd moved(const std::vector<models::FamilyCoordinate>& box, const Chart& chart,
                      const Eigen::VectorXd& values, const Eigen::Ref<const Eigen::VectorXd>& step) {
  const Eigen::VectorXd whole = step;
  Eigen::VectorXd to = values;
  chart.plus(values.data(), whole.data(), to.data());
  for (std::size_t k = 0; k < box.size(); ++k) {
    if (chart.is_part_of_quaternion(static_cast<int>(k))) continue;
    double& value = to[static_cast<Eigen::Index>(k)];
    value = std::clamp(value, box[k].lower, box[k].upper);
  }
  return to;
}

Eigen::VectorXd step_between(const Chart& chart, const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  Eigen::VectorXd step(chart.directions());
  chart.minus(to.data(), from.data(), step.data());
  return step;
}

double damping_after(double damping, double gain_ratio) {
  if (gain_ratio > 0.75) return std::max(0.2 * damping, 1e-12);
  return gain_ratio < 0.25 ? 4.0 * damping : damping;
}

void harden(SecantModel& model, double& damping) {
  if (model.has_learned()) {
    model.forget();
  } else {
    damping *= 8.0;
  }
}

double decrement(const SecantModel& model, const Eigen::VectorXd& gradient, const std::vector<int>& free) {
  const Eigen::VectorXd scale = damping_scale(model.normal());
  double largest = 0.0;
  for (const Eigen::MatrixXd& matrix : {model.normal(), model.hessian()}) {
    const auto step = damped_step(matrix, scale, gradient, free, 1e-13);
    largest = std::max(largest, step ? -step->dot(gradient) : 0.0);
  }
  return largest;
}

FreeInverse::FreeInverse(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& normal,
                         const std::vector<int>& free)
    : free_(free), scale_(damping_scale(normal)(free).cwiseSqrt().cwiseInverse()) {
  const Eigen::MatrixXd scaled = scale_.asDiagonal() * matrix(free, free) * scale_.asDiagonal();
  for (double shift = 1e-12; shift < 1e3; shift *= 10.0) {
    Eigen::MatrixXd shifted = scaled;
    shifted.diagonal().array() += shift;
    factor_.compute(shifted);
    if (factor_.info() == Eigen::Success) return;
  }
}

Eigen::MatrixXd FreeInverse::times(const Eigen::MatrixXd& right) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(right.rows(), right.cols());
  if (free_.empty()) return result;
  result(free_, Eigen::all) =
      scale_.asDiagonal() * factor_.solve(scale_.asDiagonal() * right(free_, Eigen::all));
  return result;
}

}  // namespace samara::identification
