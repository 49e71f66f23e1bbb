#pragma once

#include <span>
#include <vector>

#include "samara/motion/events/event_lanes.h"
#include "samara/motion/records/motion_record.h"

namespace samara::motion {

/// Sees the states of one motion one after another and says when an event is certain: EventLanes of one lane.
///
///   EventFinder finder(states, options);
///   while (..) if (finder.see(t, state)) finder.event();      // no allocation
class EventFinder {
 public:
  /// @throws ArgumentError for options outside their meaning.
  EventFinder(const MovingStates& states, const EventOptions& options) : lane_(states, options, 1, 1) {}

  const MovingStates& moving_states() const { return lane_.moving_states(); }
  const EventOptions& options() const { return lane_.options(); }

  /// Forgets the motion.
  void restart() { has_begun_ = false; }

  /// @param t greater than before
  /// @returns whether there is an event
  bool see(double t, std::span<const double> state);

  const Event& event() const { return lane_.event(0); }
  /// The state at the event.
  std::span<const double> state() const { return lane_.state(0); }

 private:
  EventLanes lane_;
  bool has_begun_ = false;
};

/// All events of a motion, with the states at them.
struct EventList {
  std::vector<Event> events;
  Eigen::MatrixXd states;  ///< states x events
};

/// Of states at times, a column each.
EventList events_of(const MovingStates& states, const EventOptions& options, std::span<const double> times,
                    const Eigen::Ref<const Eigen::MatrixXd>& trajectory);

/// Of a record, smoothed; the prominence is at least six deviations of what noise leaves in |v|^2. The states are
/// place, velocity and normal.
/// @throws ArgumentError as smoothed(), and for a record without attitude: its segments have no kinds.
EventList events_of(const MotionRecord& record);

}  // namespace samara::motion
