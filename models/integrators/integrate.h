#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/parametric_model.h"

/// The reference integrator: CVODES (SUNDIALS), variable-order BDF or Adams, with forward sensitivities whose
/// right-hand side is analytic: automatic derivatives of the model. (Difference quotients stall at tight
/// tolerances.)
namespace samara::models {

struct IntegrateOptions {
  /// Local error per step: relative * |x_i| + relative * scale_i, with the model's scale of each state (SI).
  double relative_tolerance = 1e-10;
  /// Most steps of the whole trajectory.
  long max_steps = 100000;
  /// Adams for non-stiff problems (the default: bodies in a fluid over moderate times), BDF otherwise.
  bool stiff = false;
  /// Longest step [s]; 0: whatever the tolerance allows, and at most 1/200 of the whole where equations as text hold a
  /// force that acts for a while only: longer ones may leap over it.
  double max_step = 0.0;
};

enum class IntegrateStatus {
  done,
  too_many_steps,  ///< max_steps were taken
  step_too_small,  ///< the local error cannot be held with any step that still advances time
  not_finite,      ///< f or its derivatives are infinite or not a number
  failed,          ///< anything else; the message says what CVODES reported
};

struct Trajectory {
  IntegrateStatus status = IntegrateStatus::failed;
  std::string message = "the integrator was not called";  ///< one sentence
  double reached = 0.0;    ///< time up to which rows are valid; later rows are NaN
  Eigen::VectorXd times;   ///< as asked for
  Eigen::MatrixXd states;  ///< times x states, SI
  /// Per free coordinate j asked for: d(states)/dq_j, times x states. Empty without sensitivities.
  std::vector<Eigen::MatrixXd> sensitivities;
  long steps = 0;
  long rhs_evaluations = 0;  ///< of f, with derivatives or without

  bool is_usable() const { return status == IntegrateStatus::done; }
};

/// Integrates from t = 0 and returns the states at the given times.
///
/// For many integrations of one model keep an Integrator: it owns solver memory and is cheap to call again.
/// One per thread.
class Integrator {
 public:
  /// @param with_sensitivities computes derivatives by all free coordinates of the model, under error control
  ///   like the states
  /// @throws ArgumentError if an option is outside its meaning.
  Integrator(const ParametricModel& model, const IntegrateOptions& options, bool with_sensitivities);
  ~Integrator();
  Integrator(Integrator&&) noexcept;
  Integrator& operator=(Integrator&&) noexcept;

  /// The same call gives the same bits, whatever was integrated before.
  /// @param q free coordinates (SI)
  /// @param times not decreasing, from 0 on
  /// @throws ArgumentError if q or times are not finite, q is outside its meaning, or times decrease.
  ///   What the model itself throws passes through.
  Trajectory operator()(std::span<const double> q, std::span<const double> times);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// One trajectory, without keeping an integrator.
Trajectory integrate(const ParametricModel& model, std::span<const double> q, std::span<const double> times,
                     const IntegrateOptions& options = {}, bool with_sensitivities = false);

}  // namespace samara::models
