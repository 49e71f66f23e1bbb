#pragma once

namespace samara::models {

/// Whole steps of the classical Runge-Kutta method for a pack of trajectories in lockstep, so that one
/// virtual call pays for many steps of many trajectories.
///
/// A variable (a state, a parameter) is (1 + directions) * width numbers: its values in all lanes, then, for
/// each direction, its tangents in all lanes. A trajectory is one lane; lanes do not touch each other.
class StepKernel {
 public:
  virtual ~StepKernel() = default;

  virtual int width() const = 0;
  virtual int directions() const = 0;

  /// Puts derived defaults where `given` (one per parameter) is false; constant defaults are in place
  /// already.
  virtual void complete(const char* given, double* p) const = 0;

  /// `steps` steps of length h; p is complete. Step i of a lane starts at its t + i h.
  /// @param t one time per lane, where its steps begin
  virtual void advance(const double* t, double h, long steps, double* x, const double* p) const = 0;

  StepKernel() = default;
  StepKernel(const StepKernel&) = delete;
  StepKernel& operator=(const StepKernel&) = delete;
};

/// What a law is compiled to. The pointers are never null.
struct StepKernels {
  const StepKernel* scalar = nullptr;         ///< one lane
  const StepKernel* pack = nullptr;           ///< as many lanes as the machine has
  const StepKernel* pack_tangents = nullptr;  ///< the same with tangents
};

}  // namespace samara::models
