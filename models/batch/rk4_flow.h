#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/parametric_model.h"

/// The flow of a model from any state and time over any interval, with its derivatives: what a filter needs from one
/// frame to the next. Steps and derivatives are those of rk4_frames.h, whose times are chosen once; here they are
/// chosen on the way, and nothing is allocated after the first start.
///
///   Rk4Flow flow(model, 1e-3, directions);
///   flow.start(q, 0.2);                  // initial values in q are the state at 0.2 s
///   flow.advance(1.0 / 98.0);            // false: a state is no longer finite
///   flow.read(state);
///   flow.read_derivatives(by_directions);
namespace samara::models {

class Rk4Flow {
 public:
  /// @param step upper bound of the length of steps [s]
  /// @param directions positions of the free coordinates by which derivatives are taken; none: values only
  /// @throws ArgumentError for a step that is not positive and for a direction that there is not.
  Rk4Flow(const ParametricModel& model, double step, std::vector<int> directions);
  ~Rk4Flow();
  Rk4Flow(Rk4Flow&&) noexcept;
  Rk4Flow& operator=(Rk4Flow&&) noexcept;

  /// @param q free coordinates (SI), as ParametricModel::check accepts them
  /// @param t s
  void start(std::span<const double> q, double t);
  /// @param duration s, 0 or more: equal steps that end exactly there
  /// @returns false if a state is infinite or not a number
  bool advance(double duration);

  double time() const;
  void read(std::span<double> state) const;
  /// d(state)/d(direction) since the start, states x directions.
  void read_derivatives(Eigen::Ref<Eigen::MatrixXd> derivatives) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace samara::models
