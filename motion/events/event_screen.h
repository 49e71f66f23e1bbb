#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

/// What EventLanes does at every state of every motion, over lanes side by side: plain numbers in rows, compiled for
/// the machine. A row holds a number of all lanes of a pack.
namespace samara::motion {

namespace event_rows {

/// What is kept of a state; its numbers as they are stand after it.
enum MarkRow : std::size_t {
  kTime,
  kSquare,  ///< |v|^2
  kSwept,   ///< three: the integral of n x dn; in a plane by its angle, the second alone
  kMarkRows = kSwept + 3
};

/// What is kept of a lane.
enum LaneRow : std::size_t {
  kNormal,               ///< three: of the state that was seen last
  kBegin = kNormal + 3,  ///< s, of the segment
  kLowest,               ///< |v|^2 of what may turn out to be an event; kNone: there is none
  kHighest,              ///< |v|^2 since the segment began, until there is one
  kLevelSince,           ///< s, since when |v|^2 hardly changes ..
  kLevelLeast,
  kLevelMost,  ///< .. and between which values
  kLaneRows
};

/// In the place of a |v|^2 that there is not.
inline constexpr double kNone = std::numeric_limits<double>::infinity();

}  // namespace event_rows

/// Rows of lanes: number `row` of lane k at first[row * stride + k].
template <class Number>
struct LaneRows {
  Number* first = nullptr;
  std::size_t stride = 0;
  Number* row(std::size_t number) const { return first + number * stride; }
};

struct EventScreen {
  enum class Attitude { angle, quaternion, normal };

  Attitude attitude_is = Attitude::normal;
  std::size_t state_count = 0, velocity_count = 0;
  std::array<std::size_t, 3> velocity = {};
  std::array<std::size_t, 4> attitude = {};
  double prominence = 0.0, shortest = 0.0, steady = 0.0;  ///< EventOptions; steady: infinite for never

  /// Puts a mark and a normal where they are missing: of a state that follows no other, so that nothing is swept.
  void begin(std::size_t lane, const LaneRows<double>& mark, const LaneRows<double>& of_lanes) const;

  /// Marks the next states of all lanes.
  /// @param states, times of them
  /// @param marks of these states, to be filled, and of the last two before, the latest first
  /// @returns bit k for a lane k that has to be looked at, as a minimum may have been passed, or an event is certain
  std::uint64_t see(std::size_t lanes, const double* times, const LaneRows<const double>& states,
                    const std::array<LaneRows<double>, 3>& marks, const LaneRows<double>& of_lanes) const;
};

}  // namespace samara::motion
