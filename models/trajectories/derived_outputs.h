#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/trajectories/trajectory_family.h"

namespace samara::models {

/// What a model derives from its states (ModelInfo::outputs), along trajectories and with the derivatives that
/// follow by the chain rule. One per thread.
class DerivedOutputs {
 public:
  /// @param model outlives it
  explicit DerivedOutputs(const ParametricModel& model);

  int count() const { return static_cast<int>(y_.size()); }

  /// What follows is at this point. @param q the free coordinates of the model
  void set(std::span<const double> q);

  /// @param t s  @param x all states  @param y outputs
  void evaluate(double t, std::span<const double> x, std::span<double> y) const;
  /// @param x_slopes states x n: derivatives of the states by anything  @param y_slopes outputs x n: that of the
  /// outputs
  /// @param coordinates which free coordinate of the model each of the n is; -1: the time
  void evaluate(double t, std::span<const double> x, const Eigen::Ref<const Eigen::MatrixXd>& x_slopes,
                std::span<const int> coordinates, std::span<double> y, Eigen::Ref<Eigen::MatrixXd> y_slopes);

 private:
  const ParametricModel& model_;
  ParameterValues p_;
  Eigen::VectorXd y_, dy_dt_;
  Eigen::MatrixXd dy_dx_, dy_dp_;
};

/// The same family with the outputs that its model derives from the states. The family itself where there are none,
/// where its equations are not known, and where it lacks a state.
std::unique_ptr<TrajectoryFamily> with_derived_outputs(std::unique_ptr<TrajectoryFamily> family);

}  // namespace samara::models
