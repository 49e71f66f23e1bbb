// What the integrators conserve: the ellipsoid 4:2:1 of Kirchhoff's equations, free, u = w = (1, 1, 1).
#include <array>
#include <chrono>
#include <cmath>
#include <vector>

#include "cases.h"
#include "samara/models/integrators/adaptive.h"
#include "samara/models/integrators/lie_group.h"
#include "samara/models/laws/registry.h"

namespace samara::benchmarks {

namespace {

using namespace models;

ParametricModel free_ellipsoid() {
  return {find_model("immersed_body"),
          {{"a", 4.0},
           {"b", 2.0},
           {"c", 1.0},
           {"density", 2.0},
           {"fluid_density", 1.0},
           {"g", 0.0},
           {"C_D0", 0.0},
           {"C_D90", 0.0},
           {"C_T", 0.0},
           {"C_R", 0.0},
           {"C_w", 0.0},
           {"ux(0)", 1.0},
           {"uy(0)", 1.0},
           {"uz(0)", 1.0},
           {"wx(0)", 1.0},
           {"wy(0)", 1.0},
           {"wz(0)", 1.0}},
          {}};
}

/// Masses and inertias of that body with its fluid, from its model.
Eigen::MatrixXd total_inertia(const ParametricModel& body) {
  const std::vector<double> p = body.parameters({});
  const auto value = [&](const std::string& name) {
    const auto& list = body.model().info().parameters;
    for (std::size_t j = 0; j < list.size(); ++j) {
      if (list[j].name == name) return p[j];
    }
    return std::nan("");
  };
  Eigen::VectorXd diagonal(6);
  for (int i = 0; i < 3; ++i) {
    const std::string axis = {"xyz"[i]};
    diagonal[i] = value("mass") + value("M_" + axis);
    diagonal[i + 3] = value("I_" + axis) + value("J_" + axis);
  }
  return diagonal.asDiagonal();
}

BodyMotion motion(const Trajectory& trajectory, Eigen::Index row) {
  const Eigen::VectorXd x = trajectory.states.row(row);
  return {{x[3], x[4], x[5], x[6]}, x.segment<3>(0), x.segment<3>(7), x.segment<3>(10)};
}

void run_kirchhoff() {
  const ParametricModel body = free_ellipsoid();
  const LieGroupIntegrator invariants(total_inertia(body));
  std::vector<double> times;
  for (int k = 0; k <= 10; ++k) times.push_back(k);
  const Trajectory trajectory = integrate_adaptive(body, {}, times);
  const BodyMotion start = motion(trajectory, 0);
  double energy = 0.0, impulse = 0.0, angular = 0.0;
  for (Eigen::Index row = 1; row < trajectory.times.size(); ++row) {
    const BodyMotion now = motion(trajectory, row);
    const auto change = [&](auto of) { return (of(now) - of(start)).norm() / of(start).norm(); };
    energy =
        std::max(energy, std::abs(invariants.kinetic_energy(now) / invariants.kinetic_energy(start) - 1.0));
    impulse = std::max(impulse, change([&](const auto& m) { return invariants.world_impulse(m); }));
    angular = std::max(angular, change([&](const auto& m) { return invariants.world_angular_impulse(m); }));
  }
  print({kModels, "kirchhoff", "energy_error", energy, "1"});
  print({kModels, "kirchhoff", "impulse_error", impulse, "1"});
  print({kModels, "kirchhoff", "angular_impulse_error", angular, "1"});
  print({kModels, "kirchhoff", "rhs_evaluations", static_cast<double>(trajectory.rhs_evaluations), "1"});
  const auto time = [&](auto integrate_once) { return time_of([&] { integrate_once(); }, 5); };
  const double adaptive = time([&] { integrate_adaptive(body, {}, times); });
  const double cvodes = time([&] { integrate(body, {}, times, {.relative_tolerance = 1e-12}); });
  print({kModels, "kirchhoff", "time", adaptive, "s", "CVODES at the same tolerance", cvodes / adaptive});
}

void run_lie_group() {
  constexpr long kSteps = 100000;
  constexpr double kStep = 0.01;
  std::vector<double> times;
  for (long k = 0; k <= kSteps; k += 100) times.push_back(kStep * static_cast<double>(k));
  const LieGroupIntegrator integrator(total_inertia(free_ellipsoid()), {.step = kStep});
  BodyMotion start;
  start.v_WB_B.setOnes();
  start.w_WB_B.setOnes();
  const auto begin = std::chrono::steady_clock::now();
  const BodyTrajectory trajectory = integrator(start, times);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  // The line fitted to the relative energy by least squares, over the whole time.
  double slope = 0.0, spread = 0.0, largest = 0.0;
  for (std::size_t k = 0; k < trajectory.motions.size(); ++k) {
    const double e =
        integrator.kinetic_energy(trajectory.motions[k]) / integrator.kinetic_energy(start) - 1.0;
    const double t = times[k] - 0.5 * times.back();
    slope += t * e;
    spread += t * t;
    largest = std::max(largest, std::abs(e));
  }
  const Eigen::Matrix3d R = trajectory.motions.back().R_WB();
  print({kModels, "liegroup", "energy_drift", std::abs(slope / spread * times.back()), "1"});
  print({kModels, "liegroup", "energy_error", largest, "1"});
  print(
      {kModels, "liegroup", "orthonormality", (R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), "1"});
  print({kModels, "liegroup", "step_time", elapsed.count() / kSteps, "s"});
}

}  // namespace

void run_invariants(const Options& options) {
  if (options.wants("kirchhoff")) run_kirchhoff();
  if (options.wants("liegroup")) run_lie_group();
}

}  // namespace samara::benchmarks
