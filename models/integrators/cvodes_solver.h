#pragma once

#include <exception>
#include <span>
#include <string>
#include <vector>

#include "samara/models/integrators/integrate.h"
#include "samara/models/integrators/sundials_handles.h"

namespace samara::models {

/// CVODES set up for one parametric model: memory, callbacks and tolerances. The driver is Integrator.
///
/// CVODES holds the address of this object, so it stays where it is.
class CvodesSolver {
 public:
  /// @throws ArgumentError if an option is outside its meaning.
  CvodesSolver(const ParametricModel& model, const IntegrateOptions& options, bool with_sensitivities);
  CvodesSolver(const CvodesSolver&) = delete;
  CvodesSolver& operator=(const CvodesSolver&) = delete;

  /// Goes to t = 0 at the (checked) free coordinates q, forgetting what was before; f will not be asked for
  /// beyond t = end.
  void start(std::span<const double> q, double end);

  /// One internal step from `t` towards `end`; `t` moves if it succeeds.
  /// @returns done, or why not, with half a sentence in `message`
  IntegrateStatus step(double& t, double end, std::string& message);

  /// Makes states() and sensitivity() those of time t, which lies in the last step or is 0 before the first
  /// one.
  void interpolate(double t);

  std::span<const double> states() const { return entries(x_.get()); }
  /// d(states)/dq_j.
  std::span<const double> sensitivity(int j) const { return entries(s_[static_cast<std::size_t>(j)]); }

  const ParametricModel& model() const { return model_; }
  const IntegrateOptions& options() const { return options_; }
  int sensitivity_count() const { return sensitivity_count_; }
  /// Evaluations of f, with derivatives or without, since the start.
  long evaluations() const { return evaluations_; }

 private:
  void create_state_solver();
  void create_sensitivity_solver();
  void start_sensitivities(const Scales& scales);
  /// Whether equations as text hold what acts for a while only, which steps that the tolerance allows would leap over:
  /// at the start states, or off them by their scales, their rates do not change smoothly over the time to `end`, or
  /// not at all though t stands in them.
  bool acts_for_a_while(double end, const Scales& scales);
  bool acts_for_a_while_at(std::span<const double> x, double end);
  /// Brings `derivatives_` to the point (t, x), unless they are there.
  void linearise(double t, std::span<const double> x);

  // What CVODES calls. 0: fine, 1: try a smaller step, -1: give up.
  static int state_rate(double t, N_Vector x, N_Vector dxdt, void* self);
  static int jacobian(double t, N_Vector x, N_Vector f, SUNMatrix matrix, void* self, N_Vector, N_Vector,
                      N_Vector);
  static int sensitivity_rate(int count, double t, N_Vector x, N_Vector dxdt, N_Vector* s, N_Vector* dsdt,
                              void* self, N_Vector, N_Vector);
  template <class Body>
  int guarded(double t, Body body);
  std::string not_finite_text() const;

  ParametricModel model_;
  IntegrateOptions options_;
  int sensitivity_count_;

  std::vector<double> q_;
  ParametricModel::Workspace workspace_;
  RhsDerivatives derivatives_;        ///< at (linearised_t_, linearised_x_)
  std::vector<double> linearised_x_;  ///< empty: not linearised yet
  double linearised_t_ = 0.0;
  std::vector<double> rate_;  ///< f at the same point; where it was not finite
  long evaluations_ = 0;
  /// The latest time at which f, or a derivative, was not finite; -1: there was none.
  double not_finite_at_ = -1.0;
  std::exception_ptr thrown_;  ///< by the model; carried past the C code

  sundials::Context context_;
  VectorHandle x_;
  VectorHandle tolerance_;
  VectorArrayHandle s_;  ///< per free coordinate j, dx/dq_j
  MatrixHandle matrix_;
  LinearSolverHandle linear_solver_;
  NonlinearSolverHandle nonlinear_solver_;
  NonlinearSolverHandle sensitivity_nonlinear_solver_;
  CvodesHandle cvodes_;
};

}  // namespace samara::models
