#include "samara/models/integrators/rkmk.h"

#include <algorithm>
#include <array>
#include <vector>

#include "samara/base/errors.h"
#include "samara/models/integrators/rotations.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

namespace {

std::vector<std::size_t> quaternions_of(const ModelInfo& info) {
  std::vector<std::size_t> places;
  for (const StateGroup& group : info.groups) {
    if (group.kind == StateGroupKind::quaternion) places.push_back(static_cast<std::size_t>(group.first));
  }
  return places;
}

Quaternion quaternion_at(std::span<const double> x, std::size_t place) {
  return {x[place], x[place + 1], x[place + 2], x[place + 3]};
}

/// Angular velocity in body axes of q' = 1/2 q (0, w), for q of any length.
Eigen::Vector3d body_rate(const Quaternion& q, const Quaternion& dq_dt) {
  const Quaternion half = product(conjugate(q), dq_dt);
  const double scale = 2.0 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return scale * Eigen::Vector3d(half[1], half[2], half[3]);
}

/// Rate of the rotation vector theta, where q_0 exp(theta) turns at w in its own axes, up to terms of order
/// theta^3, which a method of order four does not see.
Eigen::Vector3d vector_rate(const Eigen::Vector3d& theta, const Eigen::Vector3d& w) {
  const Eigen::Vector3d c = theta.cross(w);
  return w + 0.5 * c + theta.cross(c) / 12.0;
}

}  // namespace

struct RkmkIntegrator::Impl {
  Impl(const ParametricModel& parametric, const RkmkOptions& chosen)
      : model(parametric),
        options(chosen),
        workspace(model.make_workspace()),
        places(quaternions_of(model.model().info())),
        x(static_cast<std::size_t>(model.state_count())),
        y(x.size()),
        f(x.size()),
        sum(x.size()),
        theta_sum(places.size()) {}

  /// Stage i sees the attitude at the start of the step turned by theta = h node k_(i-1).
  void take_step(double t, double h, std::span<const double> q) {
    constexpr std::array kNode = {0.0, 0.5, 0.5, 1.0};
    constexpr std::array kWeight = {1.0, 2.0, 2.0, 1.0};
    std::ranges::fill(sum, 0.0);
    std::ranges::fill(theta_sum, Eigen::Vector3d::Zero());
    std::ranges::copy(x, y.begin());
    theta.assign(places.size(), Eigen::Vector3d::Zero());
    for (std::size_t stage = 0; stage < kNode.size(); ++stage) {
      model.rhs(t + kNode[stage] * h, y, q, f, workspace);
      for (std::size_t i = 0; i < x.size(); ++i) sum[i] += kWeight[stage] * f[i];
      const double next = stage + 1 < kNode.size() ? kNode[stage + 1] * h : 0.0;
      for (std::size_t k = 0; k < places.size(); ++k) {
        const Eigen::Vector3d w = body_rate(quaternion_at(y, places[k]), quaternion_at(f, places[k]));
        const Eigen::Vector3d rate = vector_rate(theta[k], w);
        theta_sum[k] += kWeight[stage] * rate;
        theta[k] = next * rate;
      }
      if (stage + 1 == kNode.size()) break;
      for (std::size_t i = 0; i < x.size(); ++i) y[i] = x[i] + next * f[i];
      turn(y, theta);
    }
    for (std::size_t i = 0; i < x.size(); ++i) y[i] = x[i] + h / 6.0 * sum[i];
    for (Eigen::Vector3d& angle : theta_sum) angle *= h / 6.0;
    turn(y, theta_sum);
    x.swap(y);
  }

  /// Puts the attitudes of x, turned by `angles` in body axes, into `state`.
  void turn(std::span<double> state, const std::vector<Eigen::Vector3d>& angles) const {
    for (std::size_t k = 0; k < places.size(); ++k) {
      const Quaternion turned =
          normalised(product(quaternion_at(x, places[k]), rotation_exponential(angles[k])));
      std::ranges::copy(turned, state.begin() + static_cast<std::ptrdiff_t>(places[k]));
    }
  }

  ParametricModel model;
  RkmkOptions options;
  ParametricModel::Workspace workspace;
  std::vector<std::size_t> places;  ///< of the quaternions among the states
  std::vector<double> x, y, f, sum;
  std::vector<Eigen::Vector3d> theta, theta_sum;  ///< per quaternion
};

RkmkIntegrator::RkmkIntegrator(const ParametricModel& model, const RkmkOptions& options) {
  check_step(options.step);
  check_max_steps(options.max_steps);
  impl_ = std::make_unique<Impl>(model, options);
  if (impl_->places.empty()) {
    throw ArgumentError(
        "model \"" + model.model().info().name +
        "\" has no quaternion among its states; one was expected, to turn it by exponentials");
  }
}
RkmkIntegrator::~RkmkIntegrator() = default;
RkmkIntegrator::RkmkIntegrator(RkmkIntegrator&&) noexcept = default;
RkmkIntegrator& RkmkIntegrator::operator=(RkmkIntegrator&&) noexcept = default;

Trajectory RkmkIntegrator::operator()(std::span<const double> q, std::span<const double> times) {
  Impl& run = *impl_;
  run.model.check(q);
  check_times(times);
  run.model.initial(q, run.x);
  return fixed_step_trajectory(times, run.options.step, run.options.max_steps, run.x,
                               [&run, q](double t, const EqualSteps& steps) {
                                 for (long k = 0; k < steps.count; ++k) {
                                   run.take_step(t + static_cast<double>(k) * steps.length, steps.length, q);
                                 }
                               });
}

Trajectory integrate_rkmk(const ParametricModel& model, std::span<const double> q,
                          std::span<const double> times, const RkmkOptions& options) {
  return RkmkIntegrator(model, options)(q, times);
}

}  // namespace samara::models
