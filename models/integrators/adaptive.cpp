#include "samara/models/integrators/adaptive.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include "samara/base/errors.h"
#include "samara/base/number_text.h"
#include "samara/base/require.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

namespace {

namespace odeint = boost::numeric::odeint;

using Fehlberg = odeint::runge_kutta_fehlberg78<std::vector<double>>;

void check_options(const AdaptiveOptions& options) {
  check_relative_tolerance(options.relative_tolerance);
  check_max_steps(options.max_steps);
  require_not_negative(options.max_step, "max_step [s]");
}

}  // namespace

struct AdaptiveIntegrator::Impl {
  Impl(const ParametricModel& parametric, const AdaptiveOptions& chosen)
      : model(parametric),
        options(chosen),
        workspace(model.make_workspace()),
        scale(static_cast<std::size_t>(model.state_count())),
        x(scale.size()),
        y(scale.size()),
        before(scale.size()) {}

  void start(std::span<const double> point) {
    q.assign(point.begin(), point.end());
    const Scales scales = model.scales(q);
    const std::vector<StateInfo>& states = model.model().info().states;
    // By powers of two, so that scaling there and back is exact.
    for (std::size_t i = 0; i < scale.size(); ++i) {
      scale[i] = std::exp2(std::round(std::log2(state_scale(states[i], scales))));
    }
    model.initial(q, x);
    for (std::size_t i = 0; i < x.size(); ++i) y[i] = x[i] / scale[i];
    t = 0.0;
    // A guess that the first rejections or acceptances correct.
    step = 1e-2 * scales.time;
    not_finite = false;
  }

  /// f in scaled states, which give all of them one absolute tolerance.
  void rate(const std::vector<double>& scaled, std::vector<double>& rates, double time) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = scaled[i] * scale[i];
    model.rhs(time, x, q, rates, workspace);
    for (std::size_t i = 0; i < x.size(); ++i) rates[i] /= scale[i];
    ++evaluations;
  }

  /// Steps to `target`. @returns half a sentence, and sets the status, if something is in the way
  template <class Stepper>
  std::string advance(Stepper& stepper, double target, Trajectory& result) {
    const auto system = [this](const auto& scaled, auto& rates, double time) { rate(scaled, rates, time); };
    while (t < target) {
      if (attempts == options.max_steps) {
        result.status = IntegrateStatus::too_many_steps;
        return "that is all the steps allowed";
      }
      ++attempts;
      if (options.max_step > 0.0) step = std::min(step, options.max_step);
      const double rest = target - t;
      // A rest of little more than a step is halved: no tiny step is left over.
      const bool cut = step >= rest;
      double h = cut ? rest : (2.0 * step > rest ? 0.5 * rest : step);
      const double tried = h;
      if (t + h == t) {
        result.status = not_finite ? IntegrateStatus::not_finite : IntegrateStatus::step_too_small;
        return not_finite ? "the right-hand side is not finite, however small the step"
                          : "no step meets the relative tolerance " + number_text(options.relative_tolerance);
      }
      before = y;
      double reached = t;
      const bool accepted = stepper.try_step(system, y, reached, h) == odeint::success;
      if (accepted && all_finite(y)) {
        t = cut ? target : reached;
        step = std::max(h, cut ? step : 0.0);
        not_finite = false;
        ++result.steps;
        continue;
      }
      // Odeint takes an error that is not a number for a small one.
      not_finite = accepted || !std::isfinite(h);
      y = before;
      step = not_finite ? 0.1 * tried : h;
    }
    return {};
  }

  ParametricModel model;
  AdaptiveOptions options;
  ParametricModel::Workspace workspace;
  std::vector<double> q, scale, x;
  std::vector<double> y, before;  ///< scaled states, now and before the step
  double t = 0.0;
  double step = 0.0;
  long attempts = 0;
  long evaluations = 0;
  bool not_finite = false;  ///< the last attempt failed for that
};

AdaptiveIntegrator::AdaptiveIntegrator(const ParametricModel& model, const AdaptiveOptions& options) {
  check_options(options);
  impl_ = std::make_unique<Impl>(model, options);
}
AdaptiveIntegrator::~AdaptiveIntegrator() = default;
AdaptiveIntegrator::AdaptiveIntegrator(AdaptiveIntegrator&&) noexcept = default;
AdaptiveIntegrator& AdaptiveIntegrator::operator=(AdaptiveIntegrator&&) noexcept = default;

Trajectory AdaptiveIntegrator::operator()(std::span<const double> q, std::span<const double> times) {
  Impl& run = *impl_;
  run.model.check(q);
  check_times(times);
  Trajectory result = unfilled_trajectory(times, run.model.state_count(), 0);
  run.start(q);
  run.attempts = run.evaluations = 0;
  const double tolerance = run.options.relative_tolerance;
  auto stepper = odeint::make_controlled(tolerance, tolerance, Fehlberg());
  for (Eigen::Index row = 0; row < result.times.size(); ++row) {
    result.message = run.advance(stepper, result.times[row], result);
    if (!result.is_usable()) break;
    for (Eigen::Index i = 0; i < result.states.cols(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      result.states(row, i) = run.y[k] * run.scale[k];
    }
  }
  result.reached = run.t;
  result.rhs_evaluations = run.evaluations;
  result.message = outcome_sentence(result, times.empty() ? 0.0 : times.back());
  return result;
}

Trajectory integrate_adaptive(const ParametricModel& model, std::span<const double> q,
                              std::span<const double> times, const AdaptiveOptions& options) {
  return AdaptiveIntegrator(model, options)(q, times);
}

}  // namespace samara::models
