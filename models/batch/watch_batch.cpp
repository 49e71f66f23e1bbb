#include "samara/models/batch/watch_batch.h"

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/batch/batch_tasks.h"
#include "samara/models/batch/lanes.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

namespace {

/// Carries the trajectories first to last - 1, each in the lane that comes free.
class WatchRun {
 public:
  WatchRun(const ParametricModel& model, const Eigen::Ref<const Eigen::MatrixXd>& points,
           const BatchObserver& observer, const WatchOptions& options, SharedProgress& progress,
           WatchedBatch& result, Eigen::Index first, Eigen::Index last)
      : kernel_(model.model(), 0),
        lanes_(model, *kernel_, {}),
        point_(points),
        observer_(observer),
        options_(options),
        progress_(progress),
        result_(result),
        next_(first),
        last_(last),
        riders_(static_cast<std::size_t>(lanes_.width())),
        t_(riders_.size(), 0.0),
        state_(static_cast<std::size_t>(model.state_count())) {}

  void operator()() {
    const EqualSteps steps = equal_steps(0.0, options_.interval, options_.step);
    for (int lane = 0; lane < lanes_.width(); ++lane) {
      lanes_.load(lane, point_(next_ < last_ ? next_ : last_ - 1));  // idle lanes need some values
      board(lane);
    }
    lanes_.complete();
    while (riding_ > 0) {
      if (!progress_.goes_on()) return give_up();
      lanes_.advance(t_, steps.length, steps.count);
      bool boarded = false;
      for (int lane = 0; lane < lanes_.width(); ++lane) boarded = look(lane) || boarded;
      if (boarded) lanes_.complete();
    }
  }

 private:
  struct Rider {
    Eigen::Index trajectory = -1;  ///< -1: the lane is idle
    long samples = 0;
  };

  void give_up() {
    const auto end_as_cancelled = [&](Eigen::Index n) {
      result_.status[static_cast<std::size_t>(n)] = BatchStatus::cancelled;
    };
    for (const Rider& rider : riders_) {
      if (rider.trajectory >= 0) end_as_cancelled(rider.trajectory);
    }
    while (next_ < last_) end_as_cancelled(next_++);
  }

  /// Gives a lane the next trajectory that wants to move.
  bool board(int lane) {
    Rider& rider = riders_[static_cast<std::size_t>(lane)];
    rider = {};
    while (next_ < last_) {
      const Eigen::Index n = next_++;
      lanes_.load(lane, point_(n));
      t_[static_cast<std::size_t>(lane)] = 0.0;
      lanes_.read(lane, state_);
      if (!observer_(n, 0.0, state_)) {
        result_.status[static_cast<std::size_t>(n)] = BatchStatus::stopped;
        continue;
      }
      rider.trajectory = n;
      ++riding_;
      return true;
    }
    return false;
  }

  /// Shows the observer what a lane has come to. @returns whether another trajectory took its place
  bool look(int lane) {
    Rider& rider = riders_[static_cast<std::size_t>(lane)];
    if (rider.trajectory < 0) return false;
    BatchStatus& status = result_.status[static_cast<std::size_t>(rider.trajectory)];
    const double t = static_cast<double>(++rider.samples) * options_.interval;
    t_[static_cast<std::size_t>(lane)] = t;
    lanes_.read(lane, state_);
    bool goes_on = false;
    if (!all_finite(state_)) {
      status = BatchStatus::not_finite;
    } else {
      result_.reached[rider.trajectory] = t;
      goes_on = observer_(rider.trajectory, t, state_);
      if (!goes_on) status = BatchStatus::stopped;
    }
    if (goes_on && t < options_.end * (1.0 - 1e-12)) return false;
    --riding_;
    return board(lane);
  }

  PassKernel kernel_;
  Lanes lanes_;
  Point point_;
  const BatchObserver& observer_;
  const WatchOptions& options_;
  SharedProgress& progress_;
  WatchedBatch& result_;
  Eigen::Index next_, last_;
  std::vector<Rider> riders_;
  std::vector<double> t_;
  std::vector<double> state_;
  int riding_ = 0;
};

}  // namespace

WatchedBatch watch_batch(const ParametricModel& model, const Eigen::Ref<const Eigen::MatrixXd>& points,
                         const BatchObserver& observer, const WatchOptions& options) {
  if (!observer) throw ArgumentError("there is no observer; a function was expected");
  check_step(options.step);
  check_max_steps(options.max_steps);
  require_positive(options.interval, "interval");
  require_positive(options.end, "end");
  check_points(model, points);
  WatchedBatch result;
  result.status.assign(static_cast<std::size_t>(points.rows()), BatchStatus::done);
  result.reached.setZero(points.rows());
  if (are_too_many(std::span(&options.interval, 1), options.step, options.max_steps)) {
    std::ranges::fill(result.status, BatchStatus::too_many_steps);
    return result;
  }
  SharedProgress progress = progress_of(options.progress, model.model(), points.rows());
  in_tasks(model.model(), points.rows(), options.threads, progress,
           [&](Eigen::Index first, Eigen::Index last) {
             WatchRun(model, points, observer, options, progress, result, first, last)();
           });
  return result;
}

}  // namespace samara::models
