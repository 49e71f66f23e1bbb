#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "samara/models/integrators/step_kernel.h"
#include "samara/models/interface/parametric_model.h"

namespace samara::models {

/// The trajectories that one kernel carries in lockstep: their states and parameters, laid out for it.
class Lanes {
 public:
  /// @param directions free coordinates by which tangents are taken, at most as many as the kernel carries
  Lanes(const ParametricModel& model, const StepKernel& kernel, std::span<const int> directions);

  int width() const { return static_cast<int>(width_); }

  /// Puts the trajectory of the (checked) free coordinates q into a lane, at t = 0.
  void load(int lane, std::span<const double> q) { load(lane, q, directions_); }
  /// The same with directions of this lane's own.
  void load(int lane, std::span<const double> q, std::span<const int> directions);

  /// To be called after loads and before steps. The other lanes stay as they are.
  void complete() { kernel_.complete(values_.given.data(), p_.data()); }

  /// @param t one time per lane
  void advance(std::span<const double> t, double h, long steps) {
    kernel_.advance(t.data(), h, steps, x_.data(), p_.data());
  }

  /// A completed parameter of one lane, for what changes it between steps.
  double parameter(int index, int lane) const { return p_[place(static_cast<std::size_t>(index), lane)]; }
  void set_parameter(int index, int lane, double value) { set_parameter(index, lane, 0, value); }
  /// @param layer 0: the value; 1 + d: its tangent along direction d
  void set_parameter(int index, int lane, int layer, double value) {
    p_[place(static_cast<std::size_t>(index), lane) + static_cast<std::size_t>(layer) * width_] = value;
  }
  /// Puts a state into a lane, without tangents.
  void set_state(int lane, std::span<const double> state);
  /// d(state)/d(direction) of what set_state() has put there.
  void set_tangent(int lane, int direction, std::span<const double> tangent);
  /// The states of a lane with their tangents, to put them back: states x (1 + directions) numbers.
  void save(int lane, std::span<double> numbers) const;
  void restore(int lane, std::span<const double> numbers);

  /// Of one variable in all lanes, from the first; the next variable lies stride() numbers on.
  double* parameters(int index) { return &p_[place(static_cast<std::size_t>(index), 0)]; }
  const double* states(int index) const { return &x_[place(static_cast<std::size_t>(index), 0)]; }
  std::size_t stride() const { return stride_; }

  double state(int index, int lane) const { return x_[place(static_cast<std::size_t>(index), lane)]; }
  void read(int lane, std::span<double> state) const { read(lane, 0, state); }
  /// d(state)/d(direction), directions counted as at construction.
  void read_tangent(int lane, int direction, std::span<double> tangent) const {
    read(lane, direction + 1, tangent);
  }

 private:
  /// Where the numbers of a variable in a lane begin; tangents follow at a distance of width_.
  std::size_t place(std::size_t variable, int lane) const {
    return variable * stride_ + static_cast<std::size_t>(lane);
  }
  void read(int lane, int layer, std::span<double> values) const;

  const ParametricModel& model_;
  const StepKernel& kernel_;
  std::vector<int> directions_;
  std::size_t width_, stride_;
  std::vector<double> defaults_;  ///< of parameters, where they are constant
  ParameterValues values_;        ///< of the lane that was loaded last; all lanes are given the same
  std::vector<double> initial_;
  std::vector<double> x_, p_;
};

}  // namespace samara::models
