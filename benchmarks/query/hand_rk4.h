#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/parametric_model.h"

/// The classical Runge-Kutta method as one writes it by hand for one law, compiled for the machine, with
/// frames between the steps by cubic Hermite polynomials: the baselines of queries.
namespace samara::benchmarks {

/// What is wanted of a trajectory: some states at some times.
struct Frames {
  std::vector<double> times;  ///< ascending
  std::vector<int> outputs;   ///< states
  double end() const { return times.back(); }
};

class HandRk4 {
 public:
  virtual ~HandRk4() = default;

  /// Equal steps from 0 to the last frame. Everything that does not depend on q may be prepared here.
  virtual void prepare(const Frames& frames, int steps) = 0;
  /// @param values outputs at the end
  virtual void end_point(const double* q, double* values) = 0;
  /// @param values times x outputs, times running fastest
  virtual void trajectory(const double* q, double* values) = 0;
  /// The same in SIMD lanes. @param points coordinates x points  @param values (times * outputs) x points
  virtual void batch(const Eigen::MatrixXd& points, Eigen::MatrixXd& values) = 0;
  /// @param slopes times x outputs x 3, by the coordinates
  virtual void with_tangents(const double* q, double* values, double* slopes) = 0;
  /// f at t = 0 of a state, for a check against the model.
  virtual void rate(const double* q, const double* x, double* dxdt) = 0;
};

/// falling_plate_nd by C_T, C_R, A.
std::unique_ptr<HandRk4> plate_rk4(const models::ParametricModel& model);
/// immersed_body in still fluid by C_D90, C_T, C_R.
std::unique_ptr<HandRk4> body_rk4(const models::ParametricModel& model);

}  // namespace samara::benchmarks
