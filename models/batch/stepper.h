#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/parametric_model.h"

/// Trajectories side by side whose coefficients change while they run: what steers a motion decides on the way.
///
///   Stepper bodies(leaf, {"C_T", "C_R"}, 1000);       // both are free parameters of `leaf`
///   for (Eigen::Index n = 0; n < 1000; ++n) bodies.load(n, q);
///   bodies.ramp(7, std::array{1.1, 2.4}, 0.05);       // body 7: there within 50 ms
///   bodies.step(1.0 / 240.0, 4);                      // a frame of 60 Hz
///   bodies.state(2, 7);                               // its third state
///
/// Steps are those of batch.h, in the same kernels, and the same to the bit for a lane whose parameters rest.
/// Parameters move by smoothsteps, c(t) = c0 + (c1 - c0) (3 s^2 - 2 s^3) with s = (t - t0)/duration, and are held
/// over a step at their value in its middle: a step has order 2 while they move, 4 while they rest. Derived
/// defaults follow what they depend on.
///
/// Nothing is allocated but when a lane is loaded for the first time. One object per thread. Lanes do not touch each
/// other, but for last digits of the sines of some laws (batch/lane_sine.h).
namespace samara::models {

class Stepper {
 public:
  struct Options {
    /// Whether lanes carry tangents; they move at the cost of the kernels with tangents then.
    bool tangents = false;
    /// Names of other free parameters that are set as they are, without ramps, such as those of the air about a body.
    std::vector<std::string> driven = {};
  };

  /// All lanes rest and run nothing until they are loaded.
  /// @param steered names of free parameters of the model that are going to change
  /// @throws ArgumentError for a name that is no free parameter or is listed twice, among both, or for no lanes.
  Stepper(const ParametricModel& model, const std::vector<std::string>& steered, Eigen::Index lanes,
          const Options& options);
  Stepper(const ParametricModel& model, const std::vector<std::string>& steered, Eigen::Index lanes)
      : Stepper(model, steered, lanes, Options()) {}
  ~Stepper();
  Stepper(Stepper&&) noexcept;
  Stepper& operator=(Stepper&&) noexcept;

  Eigen::Index lanes() const;
  int state_count() const;
  int steered_count() const;
  /// Tangents that a lane carries: 0 without them.
  int directions() const;

  /// Puts the trajectory of the free coordinates q (SI) into a lane, at t = 0, with all tangents zero. The lane runs.
  /// q is not checked: see ParametricModel::check.
  void load(Eigen::Index lane, std::span<const double> q);

  /// Moves a lane that was loaded to another state and time, its tangents zero; parameters stay as they are.
  void set_state(Eigen::Index lane, double t, std::span<const double> state);

  /// Puts d(state)/d(direction) where set_state() has left zero: of a motion that came there by other means.
  void set_tangent(Eigen::Index lane, int direction, std::span<const double> tangent);

  /// The steered parameters, in the order of construction, from now on. They must lie within their meaning.
  void set_parameters(Eigen::Index lane, std::span<const double> values);

  /// Lets them move from where they are to `target`, beginning now. What moved before ends here.
  /// @param duration 0 or more; 0 is set_parameters()
  void ramp(Eigen::Index lane, std::span<const double> target, double duration);
  /// The same where the target depends on the directions.
  /// @param by_directions d(target)/d(direction), steered x directions()
  void ramp(Eigen::Index lane, std::span<const double> target, double duration,
            const Eigen::Ref<const Eigen::MatrixXd>& by_directions);

  /// The driven parameters, in the order of Options::driven, from now on; without tangents.
  void drive(Eigen::Index lane, std::span<const double> values);

  /// A lane that does not run keeps its state and time.
  void set_running(Eigen::Index lane, bool runs);
  bool runs(Eigen::Index lane) const;

  /// `steps` steps of length h for all lanes that run. States may come out infinite or not a number: see finite().
  void step(double h, long steps = 1);

  /// Lanes are carried in packs: lane n is number n % width() of pack n / width(). What looks at all states after each
  /// step is fastest pack by pack.
  int width() const;
  Eigen::Index packs() const;
  /// step() of the lanes of one pack.
  void step_pack(Eigen::Index pack, double h, long steps = 1);
  /// The numbers of a pack as they lie in memory. State i of its lane k is states[i * stride + k].
  struct PackView {
    const double* times = nullptr;
    const double* states = nullptr;
    std::size_t stride = 0;
    std::uint64_t running = 0;  ///< bit k: its lane k
  };
  PackView pack(Eigen::Index pack) const;
  /// finite() of its lanes, a bit each.
  std::uint64_t finite_lanes(Eigen::Index pack) const;

  double time(Eigen::Index lane) const;
  double state(Eigen::Index index, Eigen::Index lane) const;
  void read(Eigen::Index lane, std::span<double> state) const;
  /// d(state)/d(direction).
  void read_tangent(Eigen::Index lane, int direction, std::span<double> tangent) const;
  /// The steered parameters at the time of the lane.
  void read_parameters(Eigen::Index lane, std::span<double> values) const;
  bool finite(Eigen::Index lane) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace samara::models
