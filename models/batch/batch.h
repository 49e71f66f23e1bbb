#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/progress.h"
#include "samara/models/interface/parametric_model.h"

/// Thousands of trajectories of one model: the classical Runge-Kutta method with fixed steps
/// (integrators/rk4.h), trajectories side by side in the lanes of SIMD registers, packs of them shared
/// between threads.
///
///   const auto batch = integrate_batch(card, points, times, {.step = 5e-4});
///   batch.states.col(batch.column(n, k));   // of trajectory n at times[k]
///
/// Results do not depend on the number of threads, to the bit; nor, but for round-off in sines and cosines,
/// on the other trajectories in its pack. A trajectory that is no longer finite does not change its
/// neighbours. Models without kernels of their own (Model::step_kernels) run one at a time in each thread.
namespace samara::models {

enum class BatchStatus {
  done,
  stopped,         ///< the observer asked to stop
  not_finite,      ///< a state is infinite or not a number
  too_many_steps,  ///< the times or the interval asked for take more than max_steps: not integrated
  cancelled,       ///< the progress callback asked to cancel before this trajectory was finished
};

struct BatchOptions {
  /// Upper bound of the step [s]. Between two times asked for, steps are equal and end exactly on them.
  double step = 1e-3;
  /// Most steps of a trajectory; where the times take more, nothing is integrated.
  long max_steps = 100000000;
  int threads = 0;  ///< 0: as many as the machine has
  /// Free coordinates by which derivatives are taken: those of the discrete trajectory, exact but for
  /// round-off.
  std::vector<std::string> tangents = {};
  ProgressCallback progress = {};  ///< asked between two times
};

struct BatchTrajectories {
  Eigen::VectorXd times;   ///< as asked for
  Eigen::MatrixXd states;  ///< states x (times of the first trajectory, of the second, ...), SI
  /// Per name in BatchOptions::tangents: d(states)/dq, shaped like states.
  std::vector<Eigen::MatrixXd> tangents;
  std::vector<BatchStatus> status;  ///< per trajectory
  /// Per trajectory, the time up to which its columns are valid; later ones are NaN. (Of a
  /// trajectory that was cancelled nothing is kept.)
  Eigen::VectorXd reached;

  Eigen::Index column(Eigen::Index trajectory, Eigen::Index time) const {
    return trajectory * times.size() + time;
  }
};

/// @param points trajectories x free coordinates (SI)
/// @param times not decreasing, from 0 on
/// @throws ArgumentError if a point, a time or an option is outside its meaning.
BatchTrajectories integrate_batch(const ParametricModel& model,
                                  const Eigen::Ref<const Eigen::MatrixXd>& points,
                                  std::span<const double> times, const BatchOptions& options = {});

}  // namespace samara::models
