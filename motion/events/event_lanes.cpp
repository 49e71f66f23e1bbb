#include "samara/motion/events/event_lanes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "samara/base/bits.h"
#include "samara/base/errors.h"
#include "samara/base/require.h"

namespace samara::motion {

using namespace event_rows;

namespace {

EventScreen screen_of(const MovingStates& states, const EventOptions& options) {
  EventScreen screen;
  screen.state_count = states.state_count();
  if (states.is_of_record()) {
    screen.attitude_is = EventScreen::Attitude::normal;
    screen.velocity_count = 3;
    screen.velocity = {3, 4, 5};
    screen.attitude = {6, 7, 8};
  } else {
    const StateLayout& layout = states.layout();
    screen.attitude_is =
        states.is_planar() ? EventScreen::Attitude::angle : EventScreen::Attitude::quaternion;
    screen.velocity_count = layout.velocities().size();
    screen.velocity = layout.velocity;
    screen.attitude = layout.attitude;
  }
  screen.prominence = options.prominence * options.mean_square_speed;
  screen.shortest = options.shortest;
  screen.steady = options.steady > 0.0 ? options.steady : kNone;
  return screen;
}

std::size_t width_of(std::size_t width, Eigen::Index lanes) {
  require(width > 0 && width <= 64, "width of packs of motions", width, "1 to 64");
  require(lanes > 0, "count of motions", lanes, "1 or more");
  return width;
}

/// The polynomial through three or four numbers at times, the first the lowest, the two next beside it.
struct LowPoint {
  std::size_t points = 0;
  std::array<double, 4> times = {}, values = {};  ///< times since that of the first

  /// When it has its minimum, between the two beside; by divided differences and Newton's method.
  double minimum_time() const {
    const double a = times[1], b = times[2], c = times[3];
    const double f_0a = (values[1] - values[0]) / a, f_ab = (values[2] - values[1]) / (b - a);
    const double f_0ab = (f_ab - f_0a) / b;
    double f_0abc = 0.0;
    if (points == 4) {
      const double f_bc = (values[3] - values[2]) / (c - b);
      f_0abc = ((f_bc - f_ab) / (c - a) - f_0ab) / c;
    }
    double t = 0.0;
    for (int iteration = 0; iteration < 4; ++iteration) {
      const double slope = f_0a + f_0ab * (2.0 * t - a) + f_0abc * (3.0 * t * t - 2.0 * t * (a + b) + a * b);
      const double bend = 2.0 * f_0ab + f_0abc * (6.0 * t - 2.0 * (a + b));
      if (!(bend > 0.0)) break;
      t = std::clamp(t - slope / bend, b, a);
    }
    return t;
  }

  /// What the numbers count in its value at t.
  std::array<double, 4> weights(double t) const {
    std::array<double, 4> all = {};
    for (std::size_t i = 0; i < points; ++i) {
      double over = 1.0, under = 1.0;
      for (std::size_t j = 0; j < points; ++j) {
        if (j == i) continue;
        over *= t - times[j];
        under *= times[i] - times[j];
      }
      all[i] = over / under;
    }
    return all;
  }
};

}  // namespace

EventLanes::EventLanes(const MovingStates& states, const EventOptions& options, Eigen::Index lanes,
                       std::size_t width)
    : states_(states),
      options_(options),
      screen_(screen_of(states, options)),
      width_(width_of(width, lanes)),
      rows_of_mark_(kMarkRows + states.state_count()),
      rows_of_pack_(kMarks * rows_of_mark_ + kLaneRows),
      packs_((static_cast<std::size_t>(lanes) + width - 1) / width),
      lanes_(packs_.size() * width) {
  require_positive(options.mean_square_speed, "mean square speed");
  require_positive(options.prominence, "prominence");
  require_positive(options.turn, "least net turn");
  if (!(options.shortest >= 0.0) || !(options.steady >= 0.0))
    throw ArgumentError(
        fmt::format("the shortest segment is {} s and the time of steady ones {} s, expected 0 or more",
                    options.shortest, options.steady));
  numbers_.assign(packs_.size() * rows_of_pack_ * width, 0.0);
  candidate_states_.assign(lanes_.size() * screen_.state_count, 0.0);
  event_states_ = candidate_states_;
}

LaneRows<double> EventLanes::rows(std::size_t pack, std::size_t first) {
  return {numbers_.data() + (pack * rows_of_pack_ + first) * width_, width_};
}
/// @param back 0: of the state that was seen last
LaneRows<double> EventLanes::mark_rows(std::size_t pack, std::size_t back) {
  return rows(pack, (packs_[pack].newest + kMarks - back) % kMarks * rows_of_mark_);
}
LaneRows<double> EventLanes::lane_rows(std::size_t pack) {
  return rows(pack, kMarks * rows_of_mark_);
}

double EventLanes::number(Eigen::Index lane, std::size_t back, std::size_t row) const {
  const std::size_t pack = pack_of(lane);
  const std::size_t mark = (packs_[pack].newest + kMarks - back) % kMarks;
  return numbers_[(pack * rows_of_pack_ + mark * rows_of_mark_ + row) * width_ + slot_of(lane)];
}

double& EventLanes::of_lane(Eigen::Index lane, LaneRow row) {
  return lane_rows(pack_of(lane)).row(row)[slot_of(lane)];
}

void EventLanes::begin(Eigen::Index lane, double t, std::span<const double> state) {
  const std::size_t pack = pack_of(lane), slot = slot_of(lane);
  const LaneRows<double> mark = mark_rows(pack, 0);
  mark.row(kTime)[slot] = t;
  for (std::size_t i = 0; i < state.size(); ++i) mark.row(kMarkRows + i)[slot] = state[i];
  screen_.begin(slot, mark, lane_rows(pack));
  // Before it there is no state, hence no minimum.
  for (std::size_t back = 1; back < kMarks; ++back) mark_rows(pack, back).row(kSquare)[slot] = -kNone;
  packs_[pack].proposed &= ~(std::uint64_t{1} << slot);
  Lane& one = lanes_[static_cast<std::size_t>(lane)];
  one.is_first = true;
  one.begin = mark_at_last(lane, state);
  of_lane(lane, kBegin) = t;
  of_lane(lane, kLowest) = kNone;
  start_level(lane, t, one.begin.square);
}

void EventLanes::copy(Eigen::Index lane, const EventLanes& other, Eigen::Index other_lane) {
  const std::size_t pack = pack_of(lane), slot = slot_of(lane);
  for (std::size_t back = 0; back < kMarks; ++back) {
    const LaneRows<double> to = mark_rows(pack, back);
    for (std::size_t row = 0; row < rows_of_mark_; ++row)
      to.row(row)[slot] = other.number(other_lane, back, row);
  }
  const std::size_t other_pack = other.pack_of(other_lane), other_slot = other.slot_of(other_lane);
  const double* from =
      other.numbers_.data() + (other_pack * rows_of_pack_ + kMarks * rows_of_mark_) * other.width_;
  const LaneRows<double> to = lane_rows(pack);
  for (std::size_t row = 0; row < kLaneRows; ++row) to.row(row)[slot] = from[row * other.width_ + other_slot];
  packs_[pack].proposed &= ~(std::uint64_t{1} << slot);
  packs_[pack].proposed |= (other.packs_[other_pack].proposed >> other_slot & 1) << slot;
  lanes_[static_cast<std::size_t>(lane)] = other.lanes_[static_cast<std::size_t>(other_lane)];
  std::ranges::copy(other.part_of(other.candidate_states_, other_lane),
                    part_of(candidate_states_, lane).begin());
  std::ranges::copy(other.part_of(other.event_states_, other_lane), part_of(event_states_, lane).begin());
}

std::span<const double> EventLanes::state(Eigen::Index lane) const {
  return part_of(event_states_, lane);
}

double EventLanes::read_before(Eigen::Index lane, std::span<double> state) const {
  for (std::size_t i = 0; i < state.size(); ++i) state[i] = number(lane, 1, kMarkRows + i);
  return number(lane, 1, kTime);
}

std::uint64_t EventLanes::see(Eigen::Index pack, const double* times, const LaneRows<const double>& states,
                              std::uint64_t lanes) {
  const auto p = static_cast<std::size_t>(pack);
  packs_[p].newest = (packs_[p].newest + 1) % kMarks;
  packs_[p].proposed = 0;
  const std::uint64_t open =
      lanes &
      screen_.see(width_, times, states, {mark_rows(p, 0), mark_rows(p, 1), mark_rows(p, 2)}, lane_rows(p));
  std::uint64_t found = 0;
  for_bits(open, [&](int slot) {
    const auto lane = static_cast<Eigen::Index>(p * width_) + slot;
    if (look(lane, times[slot])) found |= std::uint64_t{1} << slot;
  });
  return found;
}

EventLanes::Stepped EventLanes::step(models::Stepper& stepper, Eigen::Index pack, double h, long steps) {
  stepper.step_pack(pack, h, steps);
  const models::Stepper::PackView stepped = stepper.pack(pack);
  const std::uint64_t finite = stepper.finite_lanes(pack);
  return {stepped, finite,
          see(pack, stepped.times, {stepped.states, stepped.stride}, stepped.running & finite)};
}

EventLanes::Mark EventLanes::mark_at_last(Eigen::Index lane, std::span<const double> state) const {
  Mark mark = {
      .t = number(lane, 0, kTime), .square = number(lane, 0, kSquare), .place = states_.place(state)};
  for (std::size_t i = 0; i < 3; ++i) mark.swept[static_cast<Eigen::Index>(i)] = number(lane, 0, kSwept + i);
  return mark;
}

/// At a state at which something may happen. @returns whether there is an event
bool EventLanes::look(Eigen::Index lane, double t) {
  Lane& one = lanes_[static_cast<std::size_t>(lane)];
  const double now = number(lane, 0, kSquare), before = number(lane, 1, kSquare);
  const double lowest = of_lane(lane, kLowest);
  if (before < number(lane, 2, kSquare) && before <= now &&
      of_lane(lane, kHighest) - before >= screen_.prominence &&
      number(lane, 1, kTime) - one.begin.t >= screen_.shortest && before < lowest)
    propose(lane);
  const std::span<double> event_state = part_of(event_states_, lane);
  if (now - of_lane(lane, kLowest) >= screen_.prominence) {
    std::ranges::copy(part_of(candidate_states_, lane), event_state.begin());
    end_segment(lane, one.candidate, false);
  } else if (t - of_lane(lane, kLevelSince) >= screen_.steady) {
    for (std::size_t i = 0; i < event_state.size(); ++i) event_state[i] = number(lane, 0, kMarkRows + i);
    end_segment(lane, mark_at_last(lane, event_state), true);
  } else {
    return false;
  }
  start_level(lane, t, now);
  return true;
}

/// The minimum among the last states becomes the candidate.
void EventLanes::propose(Eigen::Index lane) {
  // The lowest, its neighbours, and the one before.
  constexpr std::array<std::size_t, kMarks> kBack = {1, 0, 2, 3};
  LowPoint low = {.points = number(lane, 3, kSquare) == -kNone ? kMarks - 1 : kMarks};
  const double t = number(lane, 1, kTime);
  for (std::size_t k = 0; k < low.points; ++k) {
    low.times[k] = number(lane, kBack[k], kTime) - t;
    low.values[k] = number(lane, kBack[k], kSquare);
  }
  const double since = low.minimum_time();
  const std::array<double, kMarks> weights = low.weights(since);
  Mark& candidate = lanes_[static_cast<std::size_t>(lane)].candidate;
  candidate = {.t = t + since};
  const std::span<double> state = part_of(candidate_states_, lane);
  std::ranges::fill(state, 0.0);
  for (std::size_t k = 0; k < low.points; ++k) {
    candidate.square += weights[k] * low.values[k];
    const double* mark = mark_rows(pack_of(lane), kBack[k]).first + slot_of(lane);
    for (std::size_t i = 0; i < 3; ++i)
      candidate.swept[static_cast<Eigen::Index>(i)] += weights[k] * mark[(kSwept + i) * width_];
    for (std::size_t i = 0; i < state.size(); ++i) state[i] += weights[k] * mark[(kMarkRows + i) * width_];
  }
  candidate.place = states_.place(state);
  of_lane(lane, kLowest) = candidate.square;
  packs_[pack_of(lane)].proposed |= std::uint64_t{1} << slot_of(lane);
}

void EventLanes::end_segment(Eigen::Index lane, const Mark& at, bool is_steady) {
  Lane& one = lanes_[static_cast<std::size_t>(lane)];
  Event& event = one.event;
  event.t = at.t;
  event.duration = at.t - one.begin.t;
  event.displacement = at.place - one.begin.place;
  const Eigen::Vector3d swept = at.swept - one.begin.swept;
  double signed_turn = -swept.y();
  if (!states_.is_planar()) {
    const Eigen::Vector3d left(-event.displacement.y(), event.displacement.x(), 0.0);
    // About horizontal axes: what a normal sweeps about the vertical as it precesses is yaw.
    const double size = swept.head<2>().norm();
    signed_turn = -swept.dot(left) < 0.0 ? -size : size;
  }
  event.turn = signed_turn;
  const bool turns = std::abs(signed_turn) >= options_.turn * std::numbers::pi;
  event.kind = signed_turn < 0.0 ? (turns ? EventKind::turn_minus : EventKind::swing_minus)
                                 : (turns ? EventKind::turn_plus : EventKind::swing_plus);
  event.is_steady = is_steady;
  event.is_first = one.is_first;
  one.is_first = false;
  one.begin = at;
  of_lane(lane, kBegin) = at.t;
  of_lane(lane, kLowest) = kNone;
}

void EventLanes::start_level(Eigen::Index lane, double t, double square) {
  of_lane(lane, kHighest) = of_lane(lane, kLevelLeast) = of_lane(lane, kLevelMost) = square;
  of_lane(lane, kLevelSince) = t;
}

}  // namespace samara::motion
