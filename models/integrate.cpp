#include "samara/models/integrate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "samara/base/errors.h"
#include "samara/models/cvodes_solver.h"
#include "samara/models/number_text.h"

namespace samara::models {

namespace {

void check_times(std::span<const double> times) {
  double previous = 0.0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto refuse = [&](const std::string& expected) {
      throw ArgumentError("times[" + std::to_string(k) + "] is " + number_text(times[k]) + "; " + expected +
                          " was expected");
    };
    if (!std::isfinite(times[k])) refuse("a finite number");
    if (times[k] < previous)
      refuse(number_text(previous) + (k == 0 ? "" : " (the time before it)") + " or more");
    previous = times[k];
  }
}

/// A trajectory whose rows are all still NaN.
Trajectory unfilled(std::span<const double> times, int state_count, int sensitivity_count) {
  Trajectory result;
  result.status = IntegrateStatus::done;
  result.times = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  result.states.setConstant(result.times.size(), state_count, std::numeric_limits<double>::quiet_NaN());
  result.sensitivities.assign(static_cast<std::size_t>(sensitivity_count), result.states);
  return result;
}

/// Steps until `t` has reached `target`, or something is in the way.
void advance(CvodesSolver& solver, double& t, double target, double end, Trajectory& result) {
  while (t < target && result.status == IntegrateStatus::done) {
    if (result.steps == solver.options().max_steps) {
      result.status = IntegrateStatus::too_many_steps;
      result.message = "that is all the steps allowed";
      return;
    }
    result.status = solver.step(t, end, result.message);
    if (result.status == IntegrateStatus::done) ++result.steps;
  }
}

void write_row(const CvodesSolver& solver, Eigen::Index row, Trajectory& result) {
  const auto as_row = [](std::span<const double> values) {
    return Eigen::Map<const Eigen::RowVectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  };
  result.states.row(row) = as_row(solver.states());
  for (int j = 0; j < solver.sensitivity_count(); ++j) {
    result.sensitivities[static_cast<std::size_t>(j)].row(row) = as_row(solver.sensitivity(j));
  }
}

/// One sentence from the reason, with the numbers.
std::string sentence(const Trajectory& result, double end) {
  const std::string steps = std::to_string(result.steps) + " steps";
  if (result.is_usable()) return "reached t = " + number_text(end, 6) + " in " + steps;
  return "stopped at t = " + number_text(result.reached, 6) + " of " + number_text(end, 6) + " after " +
         steps + ": " + result.message;
}

}  // namespace

struct Integrator::Impl : CvodesSolver {
  using CvodesSolver::CvodesSolver;
};

Integrator::Integrator(const ParametricModel& model, const IntegrateOptions& options, bool with_sensitivities)
    : impl_(std::make_unique<Impl>(model, options, with_sensitivities)) {}
Integrator::~Integrator() = default;
Integrator::Integrator(Integrator&&) noexcept = default;
Integrator& Integrator::operator=(Integrator&&) noexcept = default;

Trajectory Integrator::operator()(std::span<const double> q, std::span<const double> times) {
  CvodesSolver& solver = *impl_;
  solver.model().check(q);
  check_times(times);
  Trajectory result = unfilled(times, solver.model().state_count(), solver.sensitivity_count());
  const double end = times.empty() ? 0.0 : times.back();
  solver.start(q, end);

  double t = 0.0;
  for (Eigen::Index row = 0; row < result.times.size(); ++row) {
    advance(solver, t, result.times[row], end, result);
    if (!result.is_usable()) break;
    solver.interpolate(result.times[row]);
    write_row(solver, row, result);
  }
  result.reached = t;
  result.rhs_evaluations = solver.evaluations();
  result.message = sentence(result, end);
  return result;
}

Trajectory integrate(const ParametricModel& model, std::span<const double> q, std::span<const double> times,
                     const IntegrateOptions& options, bool with_sensitivities) {
  return Integrator(model, options, with_sensitivities)(q, times);
}

}  // namespace samara::models
