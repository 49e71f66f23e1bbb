#include "samara/models/batch/batch_tasks.h"

#include <cmath>

#include <fmt/format.h>
#include <tbb/info.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

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

tbb::task_arena arena_of(int threads) {
  require(threads >= 0, "threads", threads, "0 or more");
  const int cores = tbb::info::default_concurrency();
  return tbb::task_arena(threads > 0 ? std::min(threads, cores) : cores);
}

Eigen::Index task_size(const Model& model) {
  constexpr Eigen::Index kPacksPerTask = 4;
  const StepKernels* kernels = model.step_kernels();
  return kPacksPerTask * (kernels == nullptr ? 1 : kernels->pack->width());
}

SharedProgress progress_of(const ProgressCallback& callback, const Model& model, Eigen::Index trajectories) {
  return {
      callback, "integrating",
      std::max(1.0, std::ceil(static_cast<double>(trajectories) / static_cast<double>(task_size(model))))};
}

}  // namespace samara::models
