#pragma once

#include <memory>
#include <span>

#include "samara/models/integrators/integrate.h"

/// Adaptive explicit steps of high order for tight tolerances: the pair of orders 7 and 8 of E. Fehlberg
/// (NASA TR R-287, 1968) in the implementation of Boost.Odeint. On smooth, non-stiff motion it is cheaper
/// than the reference integrator below a relative tolerance of about 1e-10, and it keeps the invariants of
/// free motion to that tolerance. (On Kirchhoff's equations it needs a third of the evaluations of ARKODE's
/// use of the same pair, and fewer than Odeint's Bulirsch-Stoer method once times are asked for.)
///
/// The estimate of the error does not work where f depends on time alone: for such models take integrate.h.
namespace samara::models {

struct AdaptiveOptions {
  /// Local error per step: relative * (|x_i| + h |x_i'|) + relative * scale_i, with the model's scale of each
  /// state (SI).
  double relative_tolerance = 1e-12;
  /// Most steps of the whole trajectory, rejected ones included.
  long max_steps = 1000000;
  double max_step = 0.0;  ///< longest step [s]; 0: whatever the tolerance allows, see integrate.h
};

/// For many integrations of one model; one per thread.
class AdaptiveIntegrator {
 public:
  /// @throws ArgumentError if an option is outside its meaning.
  explicit AdaptiveIntegrator(const ParametricModel& model, const AdaptiveOptions& options = {});
  ~AdaptiveIntegrator();
  AdaptiveIntegrator(AdaptiveIntegrator&&) noexcept;
  AdaptiveIntegrator& operator=(AdaptiveIntegrator&&) noexcept;

  /// Steps end on the times asked for, so that every row has the accuracy of the steps; many more times than
  /// steps cost accordingly. The same call gives the same bits, whatever was integrated before.
  /// @param q free coordinates (SI)
  /// @param times not decreasing, from 0 on
  /// @throws ArgumentError as Integrator does. What the model itself throws passes through.
  Trajectory operator()(std::span<const double> q, std::span<const double> times);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// One trajectory, without keeping an integrator.
Trajectory integrate_adaptive(const ParametricModel& model, std::span<const double> q,
                              std::span<const double> times, const AdaptiveOptions& options = {});

}  // namespace samara::models
