#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "samara/base/bits.h"
#include "samara/models/batch/stepper.h"
#include "samara/motion/events/event.h"
#include "samara/motion/events/event_screen.h"
#include "samara/motion/events/moving_states.h"

namespace samara::motion {

/// Looks for the events of many motions side by side, in packs as Stepper carries them. What each state needs is done
/// over the lanes of a pack; only lanes in which something may happen are looked at one by one.
///
///   EventLanes lanes(states, options, stepper.lanes(), stepper.width());
///   lanes.begin(n, t, state);                              // lane n, from here on
///   while (..) lanes.see(pack, times, rows, mask);         // lanes with an event: lanes.event(n)
///
/// An event is certain when |v|^2 has risen by the prominence again. Time and state of the event are those of the
/// minimum of the cubic through the four states about it, the root of v . a; they lie some steps back. Lanes do not
/// touch each other, and take the same bits in packs of any width. Nothing is allocated once it is made.
class EventLanes {
 public:
  /// @param width of packs, at most 64: lane n is number n % width of pack n / width
  /// @throws ArgumentError for options outside their meaning, no lanes, and a width of none or more than 64.
  EventLanes(const MovingStates& states, const EventOptions& options, Eigen::Index lanes, std::size_t width);

  std::size_t width() const { return width_; }
  const MovingStates& moving_states() const { return states_; }
  const EventOptions& options() const { return options_; }

  /// Forgets the motion of a lane, and begins another one.
  void begin(Eigen::Index lane, double t, std::span<const double> state);
  /// Goes on with the motion of a lane of finders of the same model and options.
  void copy(Eigen::Index lane, const EventLanes& other, Eigen::Index other_lane);

  /// The next states of a pack, at times greater than before.
  /// @param lanes bit k: lane k of the pack is looked at; motions of others are forgotten
  /// @returns bit k for an event in lane k
  std::uint64_t see(Eigen::Index pack, const double* times, const LaneRows<const double>& states,
                    std::uint64_t lanes);

  /// A pack after some steps.
  struct Stepped {
    models::Stepper::PackView pack;
    std::uint64_t finite = 0;  ///< bit k: all numbers of its lane k are
    std::uint64_t events = 0;  ///< as see() says, of lanes that run and are finite
  };
  /// Takes the steps of a pack of as many lanes, and sees the states that they lead to.
  Stepped step(models::Stepper& stepper, Eigen::Index pack, double h, long steps = 1);

  /// Whether the state before the one that was seen last is the slowest yet of what may turn out to be an event: the
  /// step beside its minimum.
  bool proposes(Eigen::Index lane) const {
    return has_bit(packs_[pack_of(lane)].proposed, static_cast<int>(slot_of(lane)));
  }
  /// The state before the one that was seen last. @returns its time
  double read_before(Eigen::Index lane, std::span<double> state) const;

  const Event& event(Eigen::Index lane) const { return lanes_[static_cast<std::size_t>(lane)].event; }
  /// The state at the event.
  std::span<const double> state(Eigen::Index lane) const;

 private:
  static constexpr std::size_t kMarks = 4;

  /// What a segment is measured by.
  struct Mark {
    double t = 0.0, square = 0.0;  ///< |v|^2
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    Eigen::Vector3d swept = Eigen::Vector3d::Zero();  ///< integral of n x dn
  };
  struct Lane {
    Mark begin, candidate;
    Event event;
    bool is_first = true;
  };
  struct Pack {
    std::size_t newest = 0;  ///< of its marks
    std::uint64_t proposed = 0;
  };

  std::size_t pack_of(Eigen::Index lane) const { return static_cast<std::size_t>(lane) / width_; }
  std::size_t slot_of(Eigen::Index lane) const { return static_cast<std::size_t>(lane) % width_; }
  template <class List>
  auto part_of(List& all, Eigen::Index lane) const {
    return std::span(all).subspan(static_cast<std::size_t>(lane) * screen_.state_count, screen_.state_count);
  }
  LaneRows<double> rows(std::size_t pack, std::size_t first);
  LaneRows<double> mark_rows(std::size_t pack, std::size_t back);
  LaneRows<double> lane_rows(std::size_t pack);
  double number(Eigen::Index lane, std::size_t back, std::size_t row) const;
  double& of_lane(Eigen::Index lane, event_rows::LaneRow row);

  Mark mark_at_last(Eigen::Index lane, std::span<const double> state) const;
  bool look(Eigen::Index lane, double t);
  void propose(Eigen::Index lane);
  void end_segment(Eigen::Index lane, const Mark& at, bool is_steady);
  void start_level(Eigen::Index lane, double t, double square);

  MovingStates states_;
  EventOptions options_;
  EventScreen screen_;
  std::size_t width_;
  std::size_t rows_of_mark_, rows_of_pack_;
  std::vector<double> numbers_;  ///< of all packs: the rows of their marks, then those of their lanes
  std::vector<Pack> packs_;
  std::vector<Lane> lanes_;
  std::vector<double> candidate_states_, event_states_;  ///< lane by lane
};

}  // namespace samara::motion
