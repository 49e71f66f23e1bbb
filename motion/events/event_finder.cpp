#include "samara/motion/events/event_finder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"
#include "samara/motion/records/smoothed_motion.h"

namespace samara::motion {

namespace {

/// Weights of the polynomial through `points` times, at t.
void lagrange_weights(const double* times, int points, double t, double* weights) {
  for (int i = 0; i < points; ++i) {
    weights[i] = 1.0;
    for (int j = 0; j < points; ++j) {
      if (j != i) weights[i] *= (t - times[j]) / (times[i] - times[j]);
    }
  }
}

/// First and second derivative of the polynomial through points, at t.
std::array<double, 2> slopes(const double* times, const double* values, int points, double t) {
  std::array<double, 2> sum = {0.0, 0.0};
  for (int i = 0; i < points; ++i) {
    double scale = values[i];
    for (int j = 0; j < points; ++j) {
      if (j != i) scale /= times[i] - times[j];
    }
    double first = 0.0, second = 0.0;
    for (int a = 0; a < points; ++a) {
      if (a == i) continue;
      double without = 1.0;
      for (int j = 0; j < points; ++j) {
        if (j != i && j != a) without *= t - times[j];
      }
      first += without;
      for (int b = 0; b < points; ++b) {
        if (b == i || b == a) continue;
        double pair = 1.0;
        for (int j = 0; j < points; ++j) {
          if (j != i && j != a && j != b) pair *= t - times[j];
        }
        second += pair;
      }
    }
    sum[0] += scale * first;
    sum[1] += scale * second;
  }
  return sum;
}

/// How the normal turned between two states: the swept vector of the arc.
Eigen::Vector3d arc(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d axis = from.cross(to);
  const double square = axis.squaredNorm();
  // The series of asin(s)/s, to 1e-7 of the arc of a step that turns less than 0.2 rad.
  if (square < 0.04 && from.dot(to) > 0.0)
    return (1.0 + square * (1.0 / 6.0 + square * (3.0 / 40.0 + square * 15.0 / 336.0))) * axis;
  const double sine = std::sqrt(square);
  if (sine == 0.0) return Eigen::Vector3d::Zero();  // opposite: about which axis, nobody can tell
  return std::atan2(sine, from.dot(to)) / sine * axis;
}

}  // namespace

const std::vector<std::string>& event_kind_names() {
  static const std::vector<std::string> names = {"swing-", "swing+", "turn-", "turn+"};
  return names;
}

std::string to_string(EventKind kind) {
  return event_kind_names()[static_cast<std::size_t>(kind)];
}

EventKind event_kind_of(std::string_view name) {
  const auto& names = event_kind_names();
  const auto found = std::ranges::find(names, name);
  if (found == names.end())
    throw ArgumentError(fmt::format("\"{}\" is no kind of event, expected one of {}", name, join(names)));
  return static_cast<EventKind>(found - names.begin());
}

EventOptions event_options(double mean_square_speed, double body_length) {
  require_positive(mean_square_speed, "mean square speed");
  require_positive(body_length, "length of the body");
  EventOptions options;
  const double time = body_length / std::sqrt(mean_square_speed);
  options.mean_square_speed = mean_square_speed;
  options.shortest = 0.2 * time;
  options.steady = 2.0 * time;
  return options;
}

EventFinder::EventFinder(const MovingStates& states, const EventOptions& options)
    : states_(states),
      options_(options),
      prominence_(options.prominence * options.mean_square_speed),
      samples_(4 * states.state_count()),
      candidate_state_(states.state_count()),
      event_state_(states.state_count()) {
  require_positive(options.mean_square_speed, "mean square speed");
  require_positive(options.prominence, "prominence");
  require_positive(options.turn, "least net turn");
  if (!(options.shortest >= 0.0) || !(options.steady >= 0.0))
    throw ArgumentError(
        fmt::format("the shortest segment is {} s and the time of steady ones {} s, expected 0 or more",
                    options.shortest, options.steady));
}

void EventFinder::restart() {
  next_ = seen_ = 0;
  has_candidate_ = false;
  is_first_ = true;
}

void EventFinder::push(double t, std::span<const double> state) {
  Mark now;
  now.t = t;
  now.square = states_.speed_square(state);
  now.place = states_.place(state);
  if (states_.has_angle()) {
    const double angle = states_.angle(state);
    // In the plane y = 0, theta grows by a turn about -y.
    if (seen_ > 0) now.swept = mark(0).swept - Eigen::Vector3d(0.0, angle - angle_, 0.0);
    angle_ = angle;
  } else {
    const Eigen::Vector3d normal = states_.normal(state);
    if (seen_ > 0) now.swept = mark(0).swept + arc(normal_, normal);
    normal_ = normal;
  }
  marks_[static_cast<std::size_t>(next_)] = now;
  std::ranges::copy(
      state, samples_.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(next_) * state.size()));
  next_ = (next_ + 1) % 4;
  seen_ = std::min(seen_ + 1, 4);
}

bool EventFinder::is_minimum() const {
  return seen_ >= 3 && mark(1).square < mark(2).square && mark(1).square <= mark(0).square;
}

double EventFinder::minimum_time(int points) const {
  std::array<double, 4> times, squares;
  for (int k = 0; k < points; ++k) {
    times[static_cast<std::size_t>(k)] = mark(points - 1 - k).t;
    squares[static_cast<std::size_t>(k)] = mark(points - 1 - k).square;
  }
  double t = mark(1).t;
  for (int iteration = 0; iteration < 4; ++iteration) {
    const auto [slope, bend] = slopes(times.data(), squares.data(), points, t);
    if (!(bend > 0.0)) break;
    t = std::clamp(t - slope / bend, mark(2).t, mark(0).t);
  }
  return t;
}

/// The minimum among the last states becomes the candidate.
void EventFinder::propose() {
  const int points = seen_;
  std::array<double, 4> times, weights;
  for (int k = 0; k < points; ++k) times[static_cast<std::size_t>(k)] = mark(points - 1 - k).t;
  candidate_ = Mark();
  candidate_.t = minimum_time(points);
  lagrange_weights(times.data(), points, candidate_.t, weights.data());
  std::ranges::fill(candidate_state_, 0.0);
  const std::size_t count = states_.state_count();
  for (int k = 0; k < points; ++k) {
    const double weight = weights[static_cast<std::size_t>(k)];
    const int back = points - 1 - k;
    candidate_.square += weight * mark(back).square;
    candidate_.place += weight * mark(back).place;
    candidate_.swept += weight * mark(back).swept;
    const double* sample = samples_.data() + static_cast<std::size_t>((next_ + 7 - back) % 4) * count;
    for (std::size_t i = 0; i < count; ++i) candidate_state_[i] += weight * sample[i];
  }
  has_candidate_ = proposes_ = true;
}

void EventFinder::end_segment(const Mark& at, bool is_steady) {
  event_.t = at.t;
  event_.duration = at.t - begin_.t;
  event_.displacement = at.place - begin_.place;
  const Eigen::Vector3d swept = at.swept - begin_.swept;
  double signed_turn = -swept.y();
  if (!states_.is_planar()) {
    const Eigen::Vector3d left(-event_.displacement.y(), event_.displacement.x(), 0.0);
    signed_turn = -swept.dot(left) < 0.0 ? -swept.norm() : swept.norm();
  }
  event_.turn = signed_turn;
  const bool turns = std::abs(signed_turn) >= options_.turn * std::numbers::pi;
  event_.kind = signed_turn < 0.0 ? (turns ? EventKind::turn_minus : EventKind::swing_minus)
                                  : (turns ? EventKind::turn_plus : EventKind::swing_plus);
  event_.is_steady = is_steady;
  event_.is_first = is_first_;
  is_first_ = false;
  begin_ = at;
  has_candidate_ = false;
}

void EventFinder::start_level(double t, double square) {
  high_ = level_least_ = level_most_ = square;
  level_since_ = t;
}

bool EventFinder::see(double t, std::span<const double> state) {
  push(t, state);
  proposes_ = false;
  const double square = mark(0).square;
  if (seen_ == 1) {
    begin_ = mark(0);
    start_level(t, square);
    return false;
  }
  level_least_ = std::min(level_least_, square);
  level_most_ = std::max(level_most_, square);
  if (level_most_ - level_least_ >= prominence_) {
    level_since_ = t;
    level_least_ = level_most_ = square;
  }
  if (!has_candidate_) high_ = std::max(high_, square);
  if (is_minimum() && high_ - mark(1).square >= prominence_ && mark(1).t - begin_.t >= options_.shortest &&
      (!has_candidate_ || mark(1).square < candidate_.square))
    propose();
  if (has_candidate_ && square - candidate_.square >= prominence_) {
    event_state_.swap(candidate_state_);
    end_segment(candidate_, false);
    start_level(t, square);
    return true;
  }
  if (options_.steady > 0.0 && t - level_since_ >= options_.steady) {
    std::ranges::copy(state, event_state_.begin());
    end_segment(mark(0), true);
    start_level(t, square);
    return true;
  }
  return false;
}

EventList events_of(const MovingStates& states, const EventOptions& options, std::span<const double> times,
                    const Eigen::Ref<const Eigen::MatrixXd>& trajectory) {
  EventFinder finder(states, options);
  EventList list;
  std::vector<double> found, state(states.state_count());
  for (std::size_t k = 0; k < times.size(); ++k) {
    Eigen::Map<Eigen::VectorXd>(state.data(), trajectory.rows()) =
        trajectory.col(static_cast<Eigen::Index>(k));
    if (!finder.see(times[k], state)) continue;
    list.events.push_back(finder.event());
    found.insert(found.end(), finder.state().begin(), finder.state().end());
  }
  list.states =
      Eigen::Map<const Eigen::MatrixXd>(found.data(), static_cast<Eigen::Index>(states.state_count()),
                                        static_cast<Eigen::Index>(list.events.size()));
  return list;
}

EventList events_of(const MotionRecord& record) {
  if (!record.has_attitude())
    throw ArgumentError("the record has no attitude, without which its segments have no kinds");
  const SmoothedMotion motion = smoothed(record);
  Eigen::MatrixXd states(9, motion.frame_count());
  states.topRows(3) = motion.positions.transpose();
  states.middleRows(3, 3) = motion.velocities.transpose();
  if (motion.is_planar()) {
    states.row(6) = -motion.angles.transpose().array().sin();
    states.row(7).setZero();
    states.row(8) = motion.angles.transpose().array().cos();
  } else {
    states.bottomRows(3) = motion.normals.transpose();
  }
  const double square = motion.velocities.rowwise().squaredNorm().mean();
  EventOptions options;
  if (record.length > 0.0) options = event_options(square, record.length);
  options.mean_square_speed = square;
  options.prominence = std::max(options.prominence, 12.0 * motion.velocity_noise / std::sqrt(square));
  return events_of(MovingStates::of_record(motion.is_planar()), options,
                   {motion.times.data(), static_cast<std::size_t>(motion.times.size())}, states);
}

}  // namespace samara::motion
