#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

/// Events: the instants at which a falling body turns to something else, minima of |v|^2 whose prominence is 2 % of its
/// mean. They are where the source takes its maxima of curvature, without a division by |v|^3. Between two of them
/// lies a segment, which is of one of four kinds.
namespace samara::motion {

/// A turn is a segment whose net turn of the normal is 0.6 pi or more. The sign is that of theta. In space it is the
/// turn about horizontal axes, the horizontal part of the integral of n x dn, with the sign of that about the axis to
/// the right of the way, as theta has it on a way along +x. Yaw does not count: nor does a normal that precesses about
/// the vertical turn, at whatever tilt.
enum class EventKind { swing_minus, swing_plus, turn_minus, turn_plus };

inline constexpr std::size_t kEventKinds = 4;

/// In the order of EventKind: "swing-", "swing+", "turn-", "turn+".
const std::vector<std::string>& event_kind_names();
std::string to_string(EventKind kind);
/// @throws ArgumentError naming the four.
EventKind event_kind_of(std::string_view name);

struct EventOptions {
  double mean_square_speed = 0.0;  ///< of the motions, m^2/s^2; more than 0
  double prominence = 0.02;        ///< of a minimum, over that
  double turn = 0.6;               ///< least net turn of a turn, over pi
  double shortest = 0.0;           ///< s: minima nearer to the last event are none
  /// s: where |v|^2 stays within the prominence for so long, there is an event as well; 0: never.
  double steady = 0.0;
};

/// Shortest segments of 0.4 a/U and steady ones of 2 l/U, U the root of the mean square speed, l = 2 a.
/// @throws ArgumentError for numbers that are not positive and finite.
EventOptions event_options(double mean_square_speed, double body_length);

/// An event, and the segment that it ends.
struct Event {
  double t = 0.0;                                          ///< s
  EventKind kind = EventKind::swing_plus;                  ///< of the segment
  double duration = 0.0;                                   ///< s, of the segment
  double turn = 0.0;                                       ///< rad, its net turn, as EventKind has it
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  ///< along it, world, m
  /// It ends because the speed hardly changed for long, not at a minimum: the sign of its kind may be round-off.
  bool is_steady = false;
  bool is_first = true;  ///< the segment began with the first state that was seen
};

}  // namespace samara::motion
