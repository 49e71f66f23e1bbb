#include "samara/models/integrators/integrate.h"

#include "samara/models/integrators/cvodes_solver.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

namespace {

/// Steps until `t` has reached `target`, or something is in the way.
void advance(CvodesSolver& solver, double& t, double target, double end, Trajectory& result) {
  while (t < target && result.status == IntegrateStatus::done) {
    if (result.steps == solver.options().max_steps) {
      result.status = IntegrateStatus::too_many_steps;
      result.message = solver.options().stiff
                           ? "that is all the steps allowed"
                           : "that is all the steps allowed; a shorter time takes fewer, and so does BDF, of "
                             "single trajectories, where equations are stiff";
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
  Trajectory result = unfilled_trajectory(times, solver.model().state_count(), solver.sensitivity_count());
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
  result.message = outcome_sentence(result, end);
  return result;
}

Trajectory integrate(const ParametricModel& model, std::span<const double> q, std::span<const double> times,
                     const IntegrateOptions& options, bool with_sensitivities) {
  return Integrator(model, options, with_sensitivities)(q, times);
}

}  // namespace samara::models
