#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/models/integrators/rk4.h"
#include "samara/models/interface/parametric_model.h"

/// Trajectories at fixed times, the frames of a camera, with derivatives, for fits: the classical Runge-Kutta
/// method of integrators/rk4.h at times, states and directions chosen once.
///
/// One trajectory fills a whole SIMD register: its lanes carry different derivatives of it. They are those of
/// the discrete trajectory, exact but for round-off, so that a fit converges on them to the last digit.
namespace samara::models {

class Rk4Frames {
 public:
  struct Options {
    double step = 1e-3;       ///< upper bound of the step [s]
    std::vector<int> states;  ///< indices of the states that are wanted
    /// Positions of the free coordinates by which derivatives are taken.
    std::vector<int> directions;
  };

  /// @param times not decreasing, from 0 on
  /// @throws ArgumentError if a time, the step, or an index is outside its meaning.
  Rk4Frames(const ParametricModel& model, std::span<const double> times, Options options);
  ~Rk4Frames();
  Rk4Frames(Rk4Frames&&) noexcept;
  Rk4Frames& operator=(Rk4Frames&&) noexcept;

  /// @param q free coordinates (SI), as ParametricModel::check accepts them
  /// @param values times x states, of that size already
  /// @param derivatives of that size already, times x (states * directions): column s + states * d holds
  ///   d(state s)/d(direction d); null if not wanted
  /// @returns false if a state was infinite or not a number at one of the times
  bool operator()(std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> values,
                  Eigen::MatrixXd* derivatives);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace samara::models
