#include "samara/models/batch/rk4_frames.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/batch/batch_tasks.h"
#include "samara/models/batch/lanes.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

namespace {

void check_indices(const char* what, const std::vector<int>& indices, int count) {
  for (const int index : indices) {
    if (index >= 0 && index < count) continue;
    throw ArgumentError(fmt::format("{} {} was asked for; 0 to {} was expected", what, index, count - 1));
  }
}

}  // namespace

struct Rk4Frames::Impl {
  Impl(const ParametricModel& parametric, std::span<const double> frames, Options chosen)
      : model(parametric),
        times(frames.begin(), frames.end()),
        options(std::move(chosen)),
        value_through_rhs(model.model(), 0),
        value_kernel(model.model().step_kernels() ? *model.model().step_kernels()->scalar
                                                  : static_cast<const StepKernel&>(value_through_rhs)),
        values(model, value_kernel, {}),
        tangent_kernel(model.model(), static_cast<int>(options.directions.size())),
        tangents(model, *tangent_kernel, {}),
        t(static_cast<std::size_t>(tangents.width())),
        state(static_cast<std::size_t>(model.state_count())) {}

  /// Directions of one lane in one pass; none beyond the last.
  std::span<const int> directions_of(int pass, int lane) const {
    const auto each = static_cast<std::size_t>((*tangent_kernel).directions());
    const auto group = static_cast<std::size_t>(pass * tangents.width() + lane);
    const std::size_t first = std::min(group * each, options.directions.size());
    const std::size_t count = std::min(each, options.directions.size() - first);
    return std::span(options.directions).subspan(first, count);
  }

  /// To every frame in turn: record(row).
  template <class Record>
  bool run(Lanes& lanes, const Record& record) {
    std::ranges::fill(t, 0.0);
    double now = 0.0;
    for (std::size_t row = 0; row < times.size(); ++row) {
      const EqualSteps steps = equal_steps(now, times[row], options.step);
      lanes.advance(t, steps.length, steps.count);
      now = times[row];
      std::ranges::fill(t, now);
      if (!record(static_cast<Eigen::Index>(row))) return false;
    }
    return true;
  }

  bool run_values(std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> to) {
    values.load(0, q);
    values.complete();
    return run(values, [&](Eigen::Index row) { return read_values(values, row, to); });
  }

  bool read_values(const Lanes& lanes, Eigen::Index row, Eigen::Ref<Eigen::MatrixXd> to) {
    lanes.read(0, state);
    for (std::size_t s = 0; s < options.states.size(); ++s) {
      to(row, static_cast<Eigen::Index>(s)) = state[static_cast<std::size_t>(options.states[s])];
    }
    return all_finite(state);
  }

  bool run_pass(int pass, std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> to,
                Eigen::MatrixXd& derivatives) {
    for (int lane = 0; lane < tangents.width(); ++lane) tangents.load(lane, q, directions_of(pass, lane));
    tangents.complete();
    return run(tangents, [&](Eigen::Index row) {
      if (pass == 0 && !read_values(tangents, row, to)) return false;
      read_derivatives(pass, row, derivatives);
      return true;
    });
  }

  void read_derivatives(int pass, Eigen::Index row, Eigen::MatrixXd& derivatives) {
    const auto each = (*tangent_kernel).directions();
    const std::size_t wanted = options.states.size();
    for (int lane = 0; lane < tangents.width(); ++lane) {
      const auto count = static_cast<int>(directions_of(pass, lane).size());
      for (int d = 0; d < count; ++d) {
        tangents.read_tangent(lane, d, state);
        const auto direction = static_cast<std::size_t>((pass * tangents.width() + lane) * each + d);
        for (std::size_t s = 0; s < wanted; ++s) {
          derivatives(row, static_cast<Eigen::Index>(s + wanted * direction)) =
              state[static_cast<std::size_t>(options.states[s])];
        }
      }
    }
  }

  ParametricModel model;
  std::vector<double> times;
  Options options;
  ModelKernel value_through_rhs;
  const StepKernel& value_kernel;
  Lanes values;
  PassKernel tangent_kernel;
  Lanes tangents;
  std::vector<double> t, state;
};

Rk4Frames::Rk4Frames(const ParametricModel& model, std::span<const double> times, Options options) {
  check_step(options.step);
  check_times(times);
  check_indices("state", options.states, model.state_count());
  check_indices("direction", options.directions, model.free_count());
  impl_ = std::make_unique<Impl>(model, times, std::move(options));
}
Rk4Frames::~Rk4Frames() = default;
Rk4Frames::Rk4Frames(Rk4Frames&&) noexcept = default;
Rk4Frames& Rk4Frames::operator=(Rk4Frames&&) noexcept = default;

bool Rk4Frames::operator()(std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> values,
                           Eigen::MatrixXd* derivatives) {
  Impl& run = *impl_;
  if (derivatives == nullptr || run.options.directions.empty()) return run.run_values(q, values);
  for (int pass = 0; !run.directions_of(pass, 0).empty(); ++pass) {
    if (!run.run_pass(pass, q, values, *derivatives)) return false;
  }
  return true;
}

}  // namespace samara::models
