#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "samara/motion/events/moving_states.h"
#include "samara/motion/records/motion_record.h"

/// Events: the instants at which a falling body turns to something else, minima of |v|^2 whose prominence is 2 % of its
/// mean. They are where the source takes its maxima of curvature, without a division by |v|^3. Between two of them
/// lies a segment, which is of one of four kinds.
///
///   EventFinder finder(states, options);
///   while (..) if (finder.see(t, state)) finder.event();      // no allocation
namespace samara::motion {

/// A turn is a segment whose net turn of the normal is 0.6 pi or more. The sign is that of theta; in space that of
/// the turn about the horizontal axis to the right of the way, as theta has it on a way along +x; yaw does not count.
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
  double turn = 0.0;                                       ///< rad, its net turn
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  ///< along it, world, m
  /// It ends because the speed hardly changed for long, not at a minimum: the sign of its kind may be round-off.
  bool is_steady = false;
  bool is_first = true;  ///< the segment began with the first state that was seen
};

/// Sees the states of one motion one after another and says when an event is certain: when |v|^2 has risen by the
/// prominence again. Time and state of the event are those of the minimum of the cubic through the four states
/// about it, the root of v . a; they lie some steps back.
///
/// Copies of a finder of the same model do not allocate either: a search may go on from any state in many ways.
class EventFinder {
 public:
  /// @throws ArgumentError for options outside their meaning.
  EventFinder(const MovingStates& states, const EventOptions& options);

  const StateLayout& layout() const { return states_.layout(); }

  /// Forgets the motion.
  void restart();

  /// @param t greater than before
  /// @returns whether there is an event
  bool see(double t, std::span<const double> state);

  /// Whether the state before the one that was seen last is the slowest yet of what may turn out to be an event: the
  /// step beside its minimum.
  bool proposes() const { return proposes_; }
  /// Whether the state that was seen last is slower than the one before, and may come to be proposed.
  bool is_slowing() const { return seen_ > 1 && mark(0).square < mark(1).square; }

  const Event& event() const { return event_; }
  /// The state at the event.
  std::span<const double> state() const { return event_state_; }
  /// Time since the last event, or since the first state.
  double time_since(double t) const { return t - begin_.t; }

 private:
  /// What a segment is measured by.
  struct Mark {
    double t = 0.0, square = 0.0;  // |v|^2
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    Eigen::Vector3d swept = Eigen::Vector3d::Zero();  // integral of n x dn
  };

  void push(double t, std::span<const double> state);
  const Mark& mark(int back) const { return marks_[static_cast<std::size_t>((next_ + 7 - back) % 4)]; }
  bool is_minimum() const;
  void propose();
  double minimum_time(int points) const;
  void end_segment(const Mark& at, bool is_steady);
  void start_level(double t, double square);

  MovingStates states_;
  EventOptions options_;
  double prominence_;
  std::array<Mark, 4> marks_ = {};
  std::vector<double> samples_;  // the states of marks_
  int next_ = 0, seen_ = 0;
  Eigen::Vector3d normal_ = Eigen::Vector3d::Zero();  // of the state that was seen last, or its angle
  double angle_ = 0.0;
  Mark begin_, candidate_;
  bool has_candidate_ = false, proposes_ = false, is_first_ = true;
  double high_ = 0.0;
  double level_since_ = 0.0, level_least_ = 0.0, level_most_ = 0.0;  // |v|^2 where it hardly changes
  std::vector<double> candidate_state_, event_state_;
  Event event_;
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
