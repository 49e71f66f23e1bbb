#pragma once

#include <algorithm>
#include <memory>
#include <span>

#include <Eigen/Core>
#include <tbb/task_arena.h>

#include "samara/base/parallel.h"
#include "samara/base/shared_progress.h"
#include "samara/models/integrators/model_kernel.h"
#include "samara/models/interface/parametric_model.h"

/// What batches that keep their trajectories and batches that are watched have in common: points, kernels,
/// and tasks shared between threads.
namespace samara::models {

/// @throws ArgumentError naming the point.
void check_points(const ParametricModel& model, const Eigen::Ref<const Eigen::MatrixXd>& points);

/// Whether the times take more than `max_steps` steps.
bool are_too_many(std::span<const double> times, double step, long max_steps);

/// The kernel of a pass: the model's own, or one that calls Model::rhs.
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

/// Free coordinates of a point, contiguous in memory.
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

/// As many threads as asked for, at most those of the machine; 0: all.
/// @throws ArgumentError for fewer than 0.
tbb::task_arena arena_of(int threads);

/// Trajectories of one task, a few packs: the same whatever the number of threads.
Eigen::Index task_size(const Model& model);

/// Progress of `trajectories`, counted in tasks.
SharedProgress progress_of(const ProgressCallback& callback, const Model& model, Eigen::Index trajectories);

/// Calls run(first, last) for tasks of a few packs each.
template <class Run>
void in_tasks(const Model& model, Eigen::Index trajectories, int threads, SharedProgress& progress,
              const Run& run) {
  const Eigen::Index task = task_size(model);
  const Eigen::Index tasks = (trajectories + task - 1) / task;
  tbb::task_arena arena = arena_of(threads);
  arena.execute([&] {
    parallel_for(tasks, [&](Eigen::Index i) {
      run(i * task, std::min(trajectories, (i + 1) * task));
      progress.count();
    });
  });
}

}  // namespace samara::models
