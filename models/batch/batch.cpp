#include "samara/models/batch/batch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "samara/base/errors.h"
#include "samara/models/batch/lanes.h"
#include "samara/models/batch/model_kernel.h"
#include "samara/models/integrators/trajectory_tools.h"
#include "samara/models/number_text.h"

namespace samara::models {

namespace {

/// Trajectories of one task, in packs: the same whatever the number of threads.
constexpr Eigen::Index kPacksPerTask = 4;

void check_positive(double value, const char* name) {
  if (value > 0.0 && std::isfinite(value)) return;
  throw ArgumentError(fmt::format("{} is {}; a positive finite time was expected", name, number_text(value)));
}

tbb::task_arena arena_of(int threads) {
  if (threads < 0) throw ArgumentError(fmt::format("threads is {}; 0 or more was expected", threads));
  const int cores = tbb::info::default_concurrency();
  return tbb::task_arena(threads > 0 ? std::min(threads, cores) : cores);
}

/// @throws ArgumentError naming the point.
void check_points(const ParametricModel& model, const Eigen::Ref<const Eigen::MatrixXd>& points) {
  if (points.cols() != model.free_count()) {
    throw ArgumentError(
        fmt::format("the points have {} columns; one for each of the {} free coordinates was expected",
                    points.cols(), model.free_count()));
  }
  for (Eigen::Index n = 0; n < points.rows(); ++n) {
    const Eigen::VectorXd q = points.row(n);
    try {
      model.check({q.data(), static_cast<std::size_t>(q.size())});
    } catch (const ArgumentError& error) {
      throw ArgumentError(fmt::format("point {}: {}", n, error.what()));
    }
  }
}

/// Positions among the free coordinates.
std::vector<int> positions_of(const std::vector<std::string>& names, const ParametricModel& model) {
  std::vector<int> positions;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(model.free(), name, &FreeCoordinate::name);
    if (found == model.free().end()) {
      throw ArgumentError(
          fmt::format("tangents by \"{}\" were asked for; a free coordinate was expected", name));
    }
    positions.push_back(static_cast<int>(found - model.free().begin()));
  }
  return positions;
}

/// The kernel of a pass: the model's own, or one made for the occasion.
class PassKernel {
 public:
  PassKernel(const Model& model, int directions) {
    const StepKernels* kernels = model.step_kernels();
    if (kernels == nullptr) {
      through_rhs_ = std::make_unique<ModelKernel>(model, directions);
      kernel_ = through_rhs_.get();
    } else {
      kernel_ = directions > 0 ? kernels->pack_tangents : kernels->pack;
    }
  }
  const StepKernel& operator*() const { return *kernel_; }

 private:
  std::unique_ptr<ModelKernel> through_rhs_;
  const StepKernel* kernel_;
};

/// How many tangents a pass carries, of `wanted`.
int directions_per_pass(const Model& model, int wanted) {
  const StepKernels* kernels = model.step_kernels();
  return kernels == nullptr ? wanted : std::min(wanted, kernels->pack_tangents->directions());
}

/// Free coordinates of a point, as the rest of the room takes them.
class Point {
 public:
  explicit Point(const Eigen::Ref<const Eigen::MatrixXd>& points) : points_(points), q_(points.cols()) {}
  std::span<const double> operator()(Eigen::Index n) {
    q_ = points_.row(n);
    return {q_.data(), static_cast<std::size_t>(q_.size())};
  }

 private:
  const Eigen::Ref<const Eigen::MatrixXd>& points_;
  Eigen::VectorXd q_;
};

/// Fills the columns of BatchTrajectories, pack by pack.
class TimesRun {
 public:
  TimesRun(const ParametricModel& model, const Eigen::Ref<const Eigen::MatrixXd>& points,
           const BatchOptions& options, BatchTrajectories& result)
      : model_(model),
        points_(points),
        step_(options.step),
        directions_(positions_of(options.tangents, model)),
        result_(result) {}

  /// Trajectories first to last - 1, with all tangents, a few directions at a time.
  void operator()(Eigen::Index first, Eigen::Index last) const {
    const auto count = static_cast<int>(directions_.size());
    int from = 0;
    do {
      const int directions = directions_per_pass(model_.model(), count - from);
      const PassKernel kernel(model_.model(), directions);
      Lanes lanes(model_, *kernel,
                  std::span(directions_)
                      .subspan(static_cast<std::size_t>(from), static_cast<std::size_t>(directions)));
      for (Eigen::Index pack = first; pack < last; pack += lanes.width()) {
        run_pack(lanes, pack, std::min(last, pack + lanes.width()), from, directions);
      }
      from += directions;
    } while (from < count);
  }

 private:
  void run_pack(Lanes& lanes, Eigen::Index first, Eigen::Index last, int from, int directions) const {
    Point point(points_);
    // Lanes without a trajectory of their own repeat the last one.
    for (int lane = 0; lane < lanes.width(); ++lane)
      lanes.load(lane, point(std::min(first + lane, last - 1)));
    lanes.complete();
    std::vector<double> t(static_cast<std::size_t>(lanes.width()), 0.0);
    for (Eigen::Index k = 0; k < result_.times.size(); ++k) {
      const EqualSteps steps = equal_steps(t[0], result_.times[k], step_);
      lanes.advance(t, steps.length, steps.count);
      std::ranges::fill(t, result_.times[k]);
      for (Eigen::Index n = first; n < last; ++n) {
        write(lanes, static_cast<int>(n - first), n, k, from, directions);
      }
    }
  }

  void write(const Lanes& lanes, int lane, Eigen::Index n, Eigen::Index k, int from, int directions) const {
    const auto column_of = [&](Eigen::MatrixXd& matrix) {
      return std::span(matrix.col(result_.column(n, k)).data(), static_cast<std::size_t>(matrix.rows()));
    };
    BatchStatus& status = result_.status[static_cast<std::size_t>(n)];
    if (status == BatchStatus::not_finite && !(result_.times[k] <= result_.reached[n])) return;
    const std::span<double> state = column_of(result_.states);
    lanes.read(lane, state);
    if (!all_finite(state)) {
      std::ranges::fill(state, std::numeric_limits<double>::quiet_NaN());
      status = BatchStatus::not_finite;
      return;
    }
    result_.reached[n] = result_.times[k];
    for (int d = 0; d < directions; ++d) {
      lanes.read_tangent(lane, d, column_of(result_.tangents[static_cast<std::size_t>(from + d)]));
    }
  }

  const ParametricModel& model_;
  const Eigen::Ref<const Eigen::MatrixXd>& points_;
  double step_;
  std::vector<int> directions_;
  BatchTrajectories& result_;
};

/// Carries the trajectories first to last - 1, each in the lane that comes free.
class WatchRun {
 public:
  WatchRun(const ParametricModel& model, const Eigen::Ref<const Eigen::MatrixXd>& points,
           const BatchObserver& observer, const WatchOptions& options, WatchedBatch& result,
           Eigen::Index first, Eigen::Index last)
      : kernel_(model.model(), 0),
        lanes_(model, *kernel_, {}),
        point_(points),
        observer_(observer),
        options_(options),
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
  WatchedBatch& result_;
  Eigen::Index next_, last_;
  std::vector<Rider> riders_;
  std::vector<double> t_;
  std::vector<double> state_;
  int riding_ = 0;
};

bool are_too_many(std::span<const double> times, double step, long max_steps) {
  long left = max_steps;
  double t = 0.0;
  for (const double time : times) {
    left -= equal_steps(t, time, step).count;  // at least -2^62: no overflow
    if (left < 0) return true;
    t = time;
  }
  return false;
}

/// Calls run(first, last) for tasks of a few packs each.
template <class Run>
void in_tasks(const Model& model, Eigen::Index trajectories, int threads, const Run& run) {
  const StepKernels* kernels = model.step_kernels();
  const Eigen::Index task = kPacksPerTask * (kernels == nullptr ? 1 : kernels->pack->width());
  const Eigen::Index tasks = (trajectories + task - 1) / task;
  tbb::task_arena arena = arena_of(threads);
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<Eigen::Index>(0, tasks, 1),
        [&](const tbb::blocked_range<Eigen::Index>& range) {
          for (Eigen::Index i = range.begin(); i < range.end(); ++i) {
            run(i * task, std::min(trajectories, (i + 1) * task));
          }
        },
        tbb::simple_partitioner());
  });
}

}  // namespace

BatchTrajectories integrate_batch(const ParametricModel& model,
                                  const Eigen::Ref<const Eigen::MatrixXd>& points,
                                  std::span<const double> times, const BatchOptions& options) {
  check_step(options.step);
  check_max_steps(options.max_steps);
  check_times(times);
  check_points(model, points);
  BatchTrajectories result;
  result.times = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  result.states.setConstant(model.state_count(), points.rows() * result.times.size(),
                            std::numeric_limits<double>::quiet_NaN());
  result.tangents.assign(options.tangents.size(), result.states);
  result.status.assign(static_cast<std::size_t>(points.rows()), BatchStatus::done);
  result.reached.setZero(points.rows());
  if (are_too_many(times, options.step, options.max_steps)) {
    std::ranges::fill(result.status, BatchStatus::too_many_steps);
    return result;
  }
  in_tasks(model.model(), points.rows(), options.threads, TimesRun(model, points, options, result));
  return result;
}

WatchedBatch watch_batch(const ParametricModel& model, const Eigen::Ref<const Eigen::MatrixXd>& points,
                         const BatchObserver& observer, const WatchOptions& options) {
  if (!observer) throw ArgumentError("there is no observer; a function was expected");
  check_step(options.step);
  check_max_steps(options.max_steps);
  check_positive(options.interval, "interval");
  check_positive(options.end, "end");
  check_points(model, points);
  WatchedBatch result;
  result.status.assign(static_cast<std::size_t>(points.rows()), BatchStatus::done);
  result.reached.setZero(points.rows());
  if (are_too_many(std::span(&options.interval, 1), options.step, options.max_steps)) {
    std::ranges::fill(result.status, BatchStatus::too_many_steps);
    return result;
  }
  in_tasks(model.model(), points.rows(), options.threads, [&](Eigen::Index first, Eigen::Index last) {
    WatchRun(model, points, observer, options, result, first, last)();
  });
  return result;
}

}  // namespace samara::models
