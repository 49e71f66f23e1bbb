#include "samara/models/batch/rk4_flow.h"

#include <algorithm>

#include "samara/base/require.h"
#include "samara/models/batch/batch_tasks.h"
#include "samara/models/batch/lanes.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

struct Rk4Flow::Impl {
  Impl(const ParametricModel& parametric, double longest, std::vector<int> wanted)
      : model(parametric),
        step(longest),
        directions(std::move(wanted)),
        through_rhs(model.model(), 0),
        kernel(model.model(), static_cast<int>(directions.size())),
        scalar(model.model().step_kernels() ? *model.model().step_kernels()->scalar
                                            : static_cast<const StepKernel&>(through_rhs)),
        used(directions.empty() ? scalar : *kernel),
        times(static_cast<std::size_t>(used.width())),
        state(static_cast<std::size_t>(model.state_count())) {
    const std::size_t in_pass = directions_of_lane() * static_cast<std::size_t>(used.width());
    const std::size_t count = directions.empty() ? 1 : (directions.size() + in_pass - 1) / in_pass;
    for (std::size_t pass = 0; pass < count; ++pass) passes.emplace_back(model, used, std::span<const int>());
  }

  std::size_t directions_of_lane() const {
    return std::max<std::size_t>(1, static_cast<std::size_t>(used.directions()));
  }

  /// Directions of one lane of one pass; none beyond the last.
  std::span<const int> directions_of(std::size_t pass, int lane) const {
    const std::size_t each = directions_of_lane();
    const std::size_t group = pass * static_cast<std::size_t>(used.width()) + static_cast<std::size_t>(lane);
    const std::size_t first = std::min(group * each, directions.size());
    return std::span(directions).subspan(first, std::min(each, directions.size() - first));
  }

  ParametricModel model;
  double step;
  std::vector<int> directions;
  ModelKernel through_rhs;
  PassKernel kernel;
  const StepKernel& scalar;
  const StepKernel& used;
  std::vector<Lanes> passes;  ///< each carries the same trajectory, with directions of its own
  std::vector<double> times;  ///< per lane
  mutable std::vector<double> state;
  double now = 0.0;
};

Rk4Flow::Rk4Flow(const ParametricModel& model, double step, std::vector<int> directions) {
  check_step(step);
  for (const int direction : directions) {
    require(direction >= 0 && direction < model.free_count(), "direction", direction,
            "the position of a free coordinate", "Rk4Flow");
  }
  impl_ = std::make_unique<Impl>(model, step, std::move(directions));
}
Rk4Flow::~Rk4Flow() = default;
Rk4Flow::Rk4Flow(Rk4Flow&&) noexcept = default;
Rk4Flow& Rk4Flow::operator=(Rk4Flow&&) noexcept = default;

void Rk4Flow::start(std::span<const double> q, double t) {
  Impl& run = *impl_;
  run.now = t;
  for (std::size_t pass = 0; pass < run.passes.size(); ++pass) {
    Lanes& lanes = run.passes[pass];
    for (int lane = 0; lane < lanes.width(); ++lane) lanes.load(lane, q, run.directions_of(pass, lane));
    lanes.complete();
  }
}

bool Rk4Flow::advance(double duration) {
  Impl& run = *impl_;
  const EqualSteps steps = equal_steps(0.0, duration, run.step);
  std::ranges::fill(run.times, run.now);
  for (Lanes& lanes : run.passes) lanes.advance(run.times, steps.length, steps.count);
  run.now += duration;
  read(run.state);
  return all_finite(run.state);
}

double Rk4Flow::time() const {
  return impl_->now;
}

void Rk4Flow::read(std::span<double> state) const {
  impl_->passes.front().read(0, state);
}

void Rk4Flow::read_derivatives(Eigen::Ref<Eigen::MatrixXd> derivatives) const {
  const Impl& run = *impl_;
  const std::size_t each = run.directions_of_lane();
  for (std::size_t d = 0; d < run.directions.size(); ++d) {
    const std::size_t group = d / each;
    const auto width = static_cast<std::size_t>(run.used.width());
    run.passes[group / width].read_tangent(static_cast<int>(group % width), static_cast<int>(d % each),
                                           run.state);
    derivatives.col(static_cast<Eigen::Index>(d)) =
        Eigen::Map<const Eigen::VectorXd>(run.state.data(), std::ssize(run.state));
  }
}

}  // namespace samara::models
