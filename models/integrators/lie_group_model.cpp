#include "samara/models/integrators/lie_group_model.h"

#include <algorithm>
#include <vector>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

namespace {

constexpr int kStates = 13, kAttitude = 3, kVelocity = 7;

using Vector6 = Eigen::Matrix<double, 6, 1>;

void check_is_body(const ModelInfo& info) {
  const auto begins = [&](StateGroupKind kind, int first) {
    return std::ranges::any_of(info.groups,
                               [&](const StateGroup& g) { return g.kind == kind && g.first == first; });
  };
  const bool has_pose = info.states.size() == kStates && info.groups.size() == 2 &&
                        begins(StateGroupKind::position, 0) && begins(StateGroupKind::quaternion, kAttitude);
  const bool has_inertia = std::ranges::count(info.force_terms, "inertia", &ForceTermInfo::name) == 1;
  if (has_pose && has_inertia) return;
  throw ArgumentError(fmt::format(
      "the integrator on the group of rigid motions was given \"{}\", expected a model of one rigid "
      "body that lists its forces: kirchhoff_body, for one",
      info.name));
}

std::vector<double> state_of(const BodyMotion& motion) {
  std::vector<double> x(motion.p_WoBo_W.begin(), motion.p_WoBo_W.end());
  x.insert(x.end(), motion.q_WB.begin(), motion.q_WB.end());
  x.insert(x.end(), motion.v_WB_B.begin(), motion.v_WB_B.end());
  x.insert(x.end(), motion.w_WB_B.begin(), motion.w_WB_B.end());
  return x;
}

BodyMotion motion_of(const std::vector<double>& x) {
  return {{x[3], x[4], x[5], x[6]}, {x[0], x[1], x[2]}, {x[7], x[8], x[9]}, {x[10], x[11], x[12]}};
}

}  // namespace

struct LieGroupModelIntegrator::Impl {
  ParametricModel model;
  LieGroupOptions options;
  std::size_t inertial_term = 0;

  Impl(const ParametricModel& parametric, const LieGroupOptions& chosen)
      : model(parametric), options(chosen) {
    const ModelInfo& info = model.model().info();
    check_is_body(info);
    const auto term = std::ranges::find(info.force_terms, "inertia", &ForceTermInfo::name);
    inertial_term = static_cast<std::size_t>(term - info.force_terms.begin());
    const LieGroupIntegrator refuses_its_options(Eigen::MatrixXd::Identity(6, 6), options);
  }

  /// Of T = 1/2 (u, w) . I (u, w): I_ij = T(i + j) - T(i) - T(j).
  Eigen::MatrixXd inertia(const ParameterValues& p) const {
    const auto energy = [&](int i, int j) {
      std::vector<double> x(kStates, 0.0);
      x[kAttitude] = 1.0;
      x[static_cast<std::size_t>(kVelocity + i)] += 1.0;
      if (j >= 0) x[static_cast<std::size_t>(kVelocity + j)] += 1.0;
      const std::optional<double> T = model.model().kinetic_energy(0.0, x, p);
      if (!T) {
        throw ArgumentError(fmt::format(
            "the integrator on the group of rigid motions needs the kinetic energy, which \"{}\" has "
            "not",
            model.model().info().name));
      }
      return *T;
    };
    Eigen::MatrixXd I(6, 6);
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) I(i, j) = energy(i, j) - energy(i, -1) - energy(j, -1);
    }
    return 0.5 * (I + I.transpose());
  }

  Wrench wrench(double t, const BodyMotion& motion, const ParameterValues& p) const {
    std::vector<Wrench> terms(model.model().info().force_terms.size());
    model.model().forces(t, state_of(motion), p, terms);
    Wrench sum;
    for (std::size_t k = 0; k < terms.size(); ++k) {
      if (k == inertial_term) continue;
      sum.force += terms[k].force;
      sum.torque += terms[k].torque;
    }
    return sum;
  }

  /// That inertia and wrench make up the equations, near the start and on the move.
  void check_equations(const Eigen::MatrixXd& I, const ParameterValues& p, std::span<const double> q,
                       BodyMotion motion) {
    const Scales scales = model.scales(q);
    const double v = scales.velocity, w = scales.velocity / scales.length;
    motion.v_WB_B += v * Eigen::Vector3d(0.3, -0.5, 0.7);
    motion.w_WB_B += w * Eigen::Vector3d(-0.4, 0.6, 0.2);
    Vector6 velocity;
    velocity << motion.v_WB_B, motion.w_WB_B;
    const Vector6 momentum = I * velocity;
    const Eigen::Vector3d P = momentum.head<3>(), L = momentum.tail<3>();
    const Wrench outer = wrench(0.0, motion, p);
    Eigen::VectorXd load(6);
    load << P.cross(motion.w_WB_B) + outer.force,
        L.cross(motion.w_WB_B) + P.cross(motion.v_WB_B) + outer.torque;
    const Eigen::VectorXd expected = I.ldlt().solve(load);
    std::vector<double> f(kStates);
    ParametricModel::Workspace workspace = model.make_workspace();
    model.rhs(0.0, state_of(motion), q, f, workspace);
    const Eigen::Map<const Vector6> found(&f[kVelocity]);
    const double largest = std::max(found.cwiseAbs().maxCoeff(), expected.cwiseAbs().maxCoeff());
    if ((found - expected).cwiseAbs().maxCoeff() <= 1e-9 * largest) return;
    throw ArgumentError(fmt::format(
        "the integrator on the group of rigid motions was given \"{}\" with parameters for which it is "
        "not Kirchhoff's equations of a constant inertia",
        model.model().info().name));
  }
};

LieGroupModelIntegrator::LieGroupModelIntegrator(const ParametricModel& model, const LieGroupOptions& options)
    : impl_(std::make_unique<Impl>(model, options)) {}
LieGroupModelIntegrator::~LieGroupModelIntegrator() = default;
LieGroupModelIntegrator::LieGroupModelIntegrator(LieGroupModelIntegrator&&) noexcept = default;
LieGroupModelIntegrator& LieGroupModelIntegrator::operator=(LieGroupModelIntegrator&&) noexcept = default;

Trajectory LieGroupModelIntegrator::operator()(std::span<const double> q, std::span<const double> times) {
  Impl& impl = *impl_;
  impl.model.check(q);
  check_times(times);
  std::vector<double> start(kStates);
  impl.model.initial(q, start);
  const ParameterValues p = impl.model.parameter_values(q);
  const Eigen::MatrixXd inertia = impl.inertia(p);
  impl.check_equations(inertia, p, q, motion_of(start));
  const LieGroupIntegrator body(
      inertia, impl.options, [&](double t, const BodyMotion& motion) { return impl.wrench(t, motion, p); });
  const BodyTrajectory moved = body(motion_of(start), times);
  Trajectory result = unfilled_trajectory(times, kStates, 0);
  result.status = moved.status;
  result.message = moved.message;
  result.reached = moved.reached;
  result.steps = moved.steps;
  result.rhs_evaluations = moved.iterations;
  for (std::size_t i = 0; i < moved.motions.size(); ++i) {
    const std::vector<double> x = state_of(moved.motions[i]);
    result.states.row(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::RowVectorXd>(x.data(), kStates);
  }
  return result;
}

}  // namespace samara::models
