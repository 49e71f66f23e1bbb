#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/codebook.h"

/// Long motions from a codebook of a short time: windows, composed.
///
/// A codebook whose initial state is free is the flow map of its model over a window of time. Applied again
/// and again, the end of one window being the start of the next, it answers at any time, with derivatives by
/// the chain rule, as exact as the codebook's own. Short windows make this far more accurate than one
/// codebook of a long time: errors of chaotic motion grow no faster than the motion itself separates.
///
/// Needed: a model that is autonomous, and for every state s either an axis "s(0)" beside the output s, or
/// the symmetry "translation of s": its displacement over a window does not depend on where it starts. Angles
/// (states in which the model is periodic with a full turn) are wrapped.
///
/// A second chart: where a window begins outside the box, a half turn of the body or a reflection that its motion does
/// not notice (motion_symmetry.h, found in the equations) may bring it back; the window is answered there, and its end
/// taken back. So half a turn of the angle of a plate is enough, or all of it and both velocities from zero on, and
/// tilts up to a right angle carry a body of such a symmetry through upside down. Bodies whose two ends are not alike
/// need a second codebook, of the same model, parameters and time, for attitudes near upside down: with the axes
/// "qw(0)" and "qz(0)", qx(0) = 1 and qy(0) = 0 fixed. A window is answered by the first of the two whose box holds its
/// start.
///
/// Of an attitude two numbers are enough where the model has the symmetry "rotation about z": "qx(0)" and
/// "qy(0)" are axes, qw(0) = 1 and qz(0) = 0 are fixed. A window starts at the tilt alone
/// (reduced_attitude.h); the yaw, and what is displaced, are turned and carried along. A tilt by the angle
/// alpha is tan(alpha/2) long: [-1, 1] holds all up to a right angle. Without that symmetry qz(0) is an axis
/// too.
///
///   FlowMap flow_map(book);
///   const FlowMapResult fall = flow_map.run(start, parameters, times);
///   if (fall.status != FlowMapStatus::done) report(fall.message);
namespace samara::codebooks {

enum class FlowMapStatus {
  done,
  left_box,  ///< a state left the box of the codebook at the start of a window: nothing is known beyond
};

struct FlowMapResult {
  FlowMapStatus status = FlowMapStatus::done;
  std::string message;     ///< one sentence
  std::string left;        ///< the state that left the box, if one did
  double reached = 0.0;    ///< time up to which rows are valid [s]; later rows are NaN
  Eigen::MatrixXd states;  ///< times x states, SI; angles unwrapped
  /// Per time d(states)/d(start, parameters): states x (states + parameters). Empty unless asked for.
  std::vector<Eigen::MatrixXd> derivatives;
};

class FlowMap {
 public:
  /// The codebook must outlive the flow map. One per thread.
  /// @throws ArgumentError if the model is not known or not autonomous, or a state is neither output nor
  ///   axis nor free of translation.
  explicit FlowMap(const Codebook& book);
  /// With a second chart. @throws ArgumentError also if they differ in more than the box of initial values
  FlowMap(const Codebook& book, const Codebook& second);
  ~FlowMap();
  FlowMap(FlowMap&&) noexcept;
  FlowMap& operator=(FlowMap&&) noexcept;

  /// Names of the states of the model, in its order.
  const std::vector<std::string>& states() const;
  /// Coordinates of the codebook that are neither time nor initial values.
  const std::vector<Coordinate>& parameters() const;
  /// Length of a window: the codebook's time [s].
  double window() const;

  /// Composes as many windows as the times need.
  /// @param start values of all states at t = 0, SI
  /// @param parameters values of parameters(), SI
  /// @param times s, not decreasing, from 0 on, to at most 1e7 windows
  /// @throws ArgumentError for wrong sizes, values that are not finite, times that decrease;
  ///   OutsideBoxError for a parameter outside the box.
  FlowMapResult run(std::span<const double> start, std::span<const double> parameters,
                    std::span<const double> times, bool with_derivatives = false);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace samara::codebooks
