#include "samara/models/integrators/rk4.h"

#include <vector>

#include "samara/models/integrators/model_kernel.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

struct Rk4Integrator::Impl {
  Impl(const ParametricModel& parametric, const Rk4Options& chosen)
      : model(parametric),
        options(chosen),
        through_rhs(model.model(), 0),
        kernel(model.model().step_kernels() ? *model.model().step_kernels()->scalar : through_rhs),
        p(model.model().info().parameters.size()),
        x(static_cast<std::size_t>(model.state_count())) {}

  /// Values at t = 0.
  void start(std::span<const double> q) {
    model.parameter_values(q, values);
    const std::vector<ParameterInfo>& parameters = model.model().info().parameters;
    for (std::size_t j = 0; j < p.size(); ++j) {
      p[j] = values.given[j] ? values.value[j] : parameters[j].default_value.value_or(0.0);
    }
    kernel.complete(values.given.data(), p.data());
    model.initial(q, x);
  }

  ParametricModel model;
  Rk4Options options;
  ModelKernel through_rhs;
  const StepKernel& kernel;
  ParameterValues values;
  std::vector<double> p, x;
};

Rk4Integrator::Rk4Integrator(const ParametricModel& model, const Rk4Options& options) {
  check_step(options.step);
  check_max_steps(options.max_steps);
  impl_ = std::make_unique<Impl>(model, options);
}
Rk4Integrator::~Rk4Integrator() = default;
Rk4Integrator::Rk4Integrator(Rk4Integrator&&) noexcept = default;
Rk4Integrator& Rk4Integrator::operator=(Rk4Integrator&&) noexcept = default;

Trajectory Rk4Integrator::operator()(std::span<const double> q, std::span<const double> times) {
  Impl& run = *impl_;
  run.model.check(q);
  check_times(times);
  run.start(q);
  return fixed_step_trajectory(
      times, run.options.step, run.options.max_steps, run.x, [&run](double t, const EqualSteps& steps) {
        run.kernel.advance(&t, steps.length, steps.count, run.x.data(), run.p.data());
      });
}

Trajectory integrate_rk4(const ParametricModel& model, std::span<const double> q,
                         std::span<const double> times, const Rk4Options& options) {
  return Rk4Integrator(model, options)(q, times);
}

}  // namespace samara::models
