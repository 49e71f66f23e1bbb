#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "samara/models/bodies/cross_matrix.h"
#include "samara/models/integrators/integrate.h"

/// What the tests of bodies with a full pose share: states 0-2 position, 3-6 quaternion, 7-9 velocity and
/// 10-12 angular velocity in body axes.

/// The state at rest at the origin, or with what is given.
struct BodyState {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  Eigen::Vector3d w = Eigen::Vector3d::Zero();

  BodyState() = default;
  explicit BodyState(const Eigen::VectorXd& x)
      : position(x.head<3>()), q(x[3], x[4], x[5], x[6]), u(x.segment<3>(7)), w(x.segment<3>(10)) {}

  std::vector<double> vector() const {
    return {position.x(), position.y(), position.z(), q.w(), q.x(), q.y(), q.z(),
            u.x(),        u.y(),        u.z(),        w.x(), w.y(), w.z()};
  }
  Eigen::Matrix3d R() const { return q.normalized().toRotationMatrix(); }
};

inline Eigen::Vector3d random_vector(std::mt19937& random, double size) {
  std::normal_distribution<double> normal(0.0, size);
  return {normal(random), normal(random), normal(random)};
}

inline Eigen::Quaterniond random_attitude(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
}

/// The values, and in their place or beside them more of them.
inline std::map<std::string, double> joined(std::map<std::string, double> values,
                                            const std::map<std::string, double>& more) {
  for (const auto& [name, value] : more) values[name] = value;
  return values;
}

/// Values of all parameters, complete, for calls to a Model.
inline samara::models::ParameterValues parameter_values(const samara::models::Model& model,
                                                        const std::map<std::string, double>& values) {
  samara::models::ParameterValues p;
  for (const samara::models::ParameterInfo& parameter : model.info().parameters) {
    const auto it = values.find(parameter.name);
    p.given.push_back(it == values.end() ? 0 : 1);
    p.value.push_back(it == values.end() ? 0.0 : it->second);
  }
  p.value = model.completed(p);
  std::ranges::fill(p.given, 1);
  return p;
}

inline double parameter(const samara::models::Model& model, const samara::models::ParameterValues& p,
                        const std::string& name) {
  const auto& list = model.info().parameters;
  return p.value.at(static_cast<std::size_t>(
      std::ranges::find(list, name, &samara::models::ParameterInfo::name) - list.begin()));
}

/// Integrates from a state over the times; rows are states.
inline Eigen::MatrixXd motion(std::shared_ptr<const samara::models::Model> model,
                              std::map<std::string, double> values, const BodyState& start,
                              const std::vector<double>& times, double relative_tolerance = 1e-12) {
  const std::vector<double> x = start.vector();
  for (std::size_t i = 0; i < x.size(); ++i) values[model->info().states[i].name + "(0)"] = x[i];
  const samara::models::ParametricModel fixed(std::move(model), values, {});
  const samara::models::Trajectory trajectory = samara::models::integrate(
      fixed, {}, times, {.relative_tolerance = relative_tolerance, .max_steps = 1000000});
  if (!trajectory.is_usable()) throw std::runtime_error(trajectory.message);
  return trajectory.states;
}
