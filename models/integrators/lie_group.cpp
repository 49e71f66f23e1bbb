#include "samara/models/integrators/lie_group.h"

#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/number_text.h"
#include "samara/base/require.h"
#include "samara/models/integrators/rotations.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

namespace {

/// (u, w) or (P, L).
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// What a step changes.
struct Carried {
  RigidMotion pose;
  Vector6 momentum;
};

/// The momentum in the axes, and about the origin, of a body that has moved by `motion`.
Vector6 carried_momentum(const RigidMotion& motion, const Vector6& momentum) {
  const Quaternion back = conjugate(motion.q);
  const Eigen::Vector3d P = momentum.head<3>();
  const Eigen::Vector3d L = momentum.tail<3>();
  Vector6 carried;
  carried << rotate(back, P), rotate(back, L - motion.x.cross(P));
  return carried;
}

RigidMotion moved(const RigidMotion& pose, const RigidMotion& motion) {
  return {product(pose.q, motion.q), pose.x + rotate(pose.q, motion.x)};
}

BodyMotion motion_of(const RigidMotion& pose, const Vector6& velocity) {
  return {pose.q, pose.x, velocity.head<3>(), velocity.tail<3>()};
}

Vector6 velocity_of(const BodyMotion& motion) {
  Vector6 velocity;
  velocity << motion.v_WB_B, motion.w_WB_B;
  return velocity;
}

/// Steps of a symmetric method of order two whose composition has the order asked for, in units of the step.
std::vector<double> composition(int order) {
  if (order == 2) return {1.0};
  const double outer = 1.0 / (4.0 - std::cbrt(4.0));
  return {outer, outer, 1.0 - 4.0 * outer, outer, outer};
}

Matrix6 checked_inertia(const Eigen::Ref<const Eigen::MatrixXd>& inertia) {
  if (inertia.rows() != 6 || inertia.cols() != 6) {
    throw ArgumentError(
        fmt::format("the inertia is {} x {}; 6 x 6 was expected", inertia.rows(), inertia.cols()));
  }
  if (!inertia.allFinite()) throw ArgumentError("the inertia has an entry that is not a finite number");
  // Entries with different units: compare each with its own diagonal.
  for (Eigen::Index i = 0; i < 6; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const double size = std::sqrt(std::abs(inertia(i, i) * inertia(j, j)));
      if (std::abs(inertia(i, j) - inertia(j, i)) <= 1e-8 * size) continue;
      throw ArgumentError(
          fmt::format("the inertia has {} at ({}, {}) and {} at ({}, {}); a symmetric matrix was expected",
                      number_text(inertia(i, j)), i, j, number_text(inertia(j, i)), j, i));
    }
  }
  const Matrix6 symmetric = 0.5 * (inertia + inertia.transpose());
  if (Eigen::LLT<Matrix6>(symmetric).info() != Eigen::Success) {
    throw ArgumentError(
        "the inertia is not positive definite; a body with mass about every axis was expected");
  }
  return symmetric;
}

}  // namespace

Eigen::Matrix3d BodyMotion::R_WB() const {
  Eigen::Matrix3d R;
  for (int j = 0; j < 3; ++j) R.col(j) = rotate(q_WB, Eigen::Vector3d::Unit(j));
  return R;
}

struct LieGroupIntegrator::Impl {
  Impl(const Eigen::Ref<const Eigen::MatrixXd>& given, const LieGroupOptions& chosen, BodyWrench acting)
      : inertia(checked_inertia(given)),
        cholesky(inertia),
        options(chosen),
        wrench(std::move(acting)),
        substeps(composition(chosen.order)) {}

  /// One step of the midpoint method. @returns whether the iteration converged
  bool take_step(double t, double h, Carried& body, long& iterations) const {
    constexpr double kRoundOff = 4.0 * std::numeric_limits<double>::epsilon();
    Vector6 xi = cholesky.solve(body.momentum);
    double last_change = std::numeric_limits<double>::infinity();
    for (int i = 0; i < options.max_iterations; ++i) {
      ++iterations;
      const Vector6 half_step = 0.5 * h * xi;
      const RigidMotion half = rigid_exponential(half_step.head<3>(), half_step.tail<3>());
      Vector6 momentum = carried_momentum(half, body.momentum);
      if (wrench) {
        const Wrench acting = wrench(t + 0.5 * h, motion_of(moved(body.pose, half), xi));
        momentum.head<3>() += h * acting.force;
        momentum.tail<3>() += h * acting.torque;
      }
      momentum = carried_momentum(half, momentum);
      const Vector6 next = cholesky.solve(0.5 * (body.momentum + momentum));
      // In the norm of the energy, which knows the units. NaN passes as converged: the driver finds it.
      const double change = energy_norm(next - xi);
      const double size = energy_norm(next);
      const bool settled = !(change > kRoundOff * size);
      const bool stalled = change >= last_change && change < 1e3 * kRoundOff * size;
      if (settled || stalled) {
        body.momentum = momentum;
        body.pose = moved(moved(body.pose, half), half);
        body.pose.q = normalised(body.pose.q);  // takes back round-off, turns nothing
        return true;
      }
      xi = next;
      last_change = change;
    }
    return false;
  }

  double energy_norm(const Vector6& velocity) const { return std::sqrt(velocity.dot(inertia * velocity)); }

  /// Steps to the next time. @returns half a sentence if something is in the way
  std::string advance(double t, const EqualSteps& steps, Carried& body, BodyTrajectory& result) const {
    if (steps.count > options.max_steps - result.steps) {
      result.status = IntegrateStatus::too_many_steps;
      return "the next time takes more steps than allowed";
    }
    for (long step = 0; step < steps.count; ++step) {
      double at = t + static_cast<double>(step) * steps.length;
      for (const double part : substeps) {
        if (!take_step(at, part * steps.length, body, result.iterations)) {
          result.status = IntegrateStatus::failed;
          return "the velocity half-way through a step was not found; shorter steps help";
        }
        at += part * steps.length;
      }
      ++result.steps;
    }
    if (!body.momentum.allFinite() || !body.pose.x.allFinite()) {
      result.status = IntegrateStatus::not_finite;
      return "the motion is not finite at the next time asked for";
    }
    return {};
  }

  Matrix6 inertia;
  Eigen::LLT<Matrix6> cholesky;
  LieGroupOptions options;
  BodyWrench wrench;
  std::vector<double> substeps;
};

LieGroupIntegrator::LieGroupIntegrator(const Eigen::Ref<const Eigen::MatrixXd>& inertia,
                                       const LieGroupOptions& options, BodyWrench wrench) {
  check_step(options.step);
  check_max_steps(options.max_steps);
  require(options.order == 2 || options.order == 4, "order", options.order, "2 or 4");
  require(options.max_iterations >= 1, "max_iterations", options.max_iterations, "1 or more");
  impl_ = std::make_shared<const Impl>(inertia, options, std::move(wrench));
}

BodyTrajectory LieGroupIntegrator::operator()(const BodyMotion& start, std::span<const double> times) const {
  check_times(times);
  const Eigen::Map<const Eigen::Vector4d> q(start.q_WB.data());
  if (!q.allFinite() || !(q.norm() > 0.0) || !start.p_WoBo_W.allFinite() || !velocity_of(start).allFinite()) {
    throw ArgumentError(
        "the start has a number that is not finite, or a zero quaternion; a motion was expected");
  }
  BodyTrajectory result;
  result.status = IntegrateStatus::done;
  result.times = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  result.motions.reserve(times.size());
  Carried body = {{normalised(start.q_WB), start.p_WoBo_W}, impl_->inertia * velocity_of(start)};
  for (const double time : times) {
    const EqualSteps steps = equal_steps(result.reached, time, impl_->options.step);
    result.message = impl_->advance(result.reached, steps, body, result);
    if (!result.is_usable()) break;
    result.reached = time;
    result.motions.push_back(motion_of(body.pose, impl_->cholesky.solve(body.momentum)));
  }
  const std::string stand = fmt::format("t = {} in {} steps", number_text(result.reached, 6), result.steps);
  result.message = result.is_usable() ? "reached " + stand : "stopped at " + stand + ": " + result.message;
  return result;
}

double LieGroupIntegrator::kinetic_energy(const BodyMotion& motion) const {
  const Vector6 velocity = velocity_of(motion);
  return 0.5 * velocity.dot(impl_->inertia * velocity);
}

Eigen::Vector3d LieGroupIntegrator::world_impulse(const BodyMotion& motion) const {
  const Vector6 momentum = impl_->inertia * velocity_of(motion);
  return rotate(motion.q_WB, momentum.head<3>());
}

Eigen::Vector3d LieGroupIntegrator::world_angular_impulse(const BodyMotion& motion) const {
  const Vector6 momentum = impl_->inertia * velocity_of(motion);
  return rotate(motion.q_WB, momentum.tail<3>()) + motion.p_WoBo_W.cross(world_impulse(motion));
}

}  // namespace samara::models
