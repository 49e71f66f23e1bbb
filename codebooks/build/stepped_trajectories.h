#pragma once

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "samara/base/errors.h"
#include "samara/base/progress.h"
#include "samara/base/termination.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/pgd/fields/error_scale.h"

namespace samara::codebooks {

/// Takes an ending out of the searches under way, to solve_by_steps(), which returns it.
class SteppedEnd : public Error {
 public:
  explicit SteppedEnd(Ending why) : Error(why.message), ending(std::move(why)) {}
  Ending ending;
};

/// Trajectories of a model by Runge-Kutta steps of one length, counted and bounded.
class SteppedTrajectories {
 public:
  /// @param step the first, longest one [s]. The model and the callback must outlive the object.
  SteppedTrajectories(const models::ParametricModel& model, double step, int threads, long max_calls,
                      const ProgressCallback& progress);

  /// A column per point: states fastest, then times. @param points coordinates x points
  /// @throws SteppedEnd where a trajectory is not finite, or no more are allowed
  Eigen::MatrixXd operator()(const Eigen::MatrixXd& points, const std::vector<double>& times);

  double step() const { return step_; }
  void set_step(double step) { step_ = step; }
  long calls() const { return calls_; }
  /// How many more are allowed.
  long left() const { return max_calls_ - calls_; }
  /// Those of an interrupted build count, what is walked again to get there does not.
  void go_on_from(long calls) { calls_ = calls; }
  /// For the progress callback.
  void tell(std::string stage, double fraction);

 private:
  const models::ParametricModel& model_;
  double step_;
  int threads_;
  long max_calls_;
  const ProgressCallback& progress_;
  Progress stage_;
  long calls_ = 0;
};

/// Steps of so many to the end of the time are the first to be tried.
constexpr int kFirstSteps = 32;

/// Halves the step until the pilots err by no more than the tolerance, over the ranges of the states
/// (pgd/fields/error_scale.h).
/// @param pilots coordinates x points
/// @throws SteppedEnd where the steps would have to be too short
void choose_step(SteppedTrajectories& trajectories, const Eigen::MatrixXd& pilots, double end,
                 const pgd::OutputMeasure& measure, double tolerance);

}  // namespace samara::codebooks
