#pragma once

#include <functional>
#include <span>

#include <Eigen/Core>

#include "samara/models/batch/batch.h"

namespace samara::models {

/// Called with a state of a trajectory from time to time; returning false ends the trajectory. Calls for one
/// trajectory come in the order of time and one after another; those for different ones come from different
/// threads at once.
using BatchObserver = std::function<bool(Eigen::Index trajectory, double t, std::span<const double> state)>;

struct WatchOptions {
  double step = 1e-3;      ///< upper bound of the step [s]; steps divide the interval
  double interval = 1e-2;  ///< between two calls of the observer [s]; the first is at t = 0
  double end = 1.0;        ///< the last call is at the first multiple of the interval that reaches it [s]
  /// Most steps of an interval; where it takes more, nothing is integrated and the observer is not called.
  long max_steps = 100000000;
  int threads = 0;                 ///< 0: as many as the machine has
  ProgressCallback progress = {};  ///< asked between two intervals
};

struct WatchedBatch {
  std::vector<BatchStatus> status;  ///< per trajectory
  Eigen::VectorXd reached;          ///< per trajectory, the time of the last call of the observer
};

/// Runs trajectories of any length without keeping them: for statistics (turns, drift, time of landing)
/// gathered on the way. A lane whose trajectory has ended takes the next one.
/// @throws ArgumentError if a point or an option is outside its meaning. What the observer throws passes
/// through.
WatchedBatch watch_batch(const ParametricModel& model, const Eigen::Ref<const Eigen::MatrixXd>& points,
                         const BatchObserver& observer, const WatchOptions& options = {});

}  // namespace samara::models
