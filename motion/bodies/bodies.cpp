#include "samara/motion/bodies/bodies.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "samara/base/bits.h"
#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/batch/stepper.h"
#include "samara/models/bodies/body_pose.h"
#include "samara/motion/bodies/air_about_bodies.h"
#include "samara/motion/bodies/look_ahead.h"
#include "samara/motion/bodies/steered_model.h"

namespace samara::motion {

namespace {

/// What is remembered of one body.
struct Body {
  Body(std::uint64_t seed, std::uint64_t number) : stream(seed, number) {}

  BodyStatus status = BodyStatus::waiting;
  Stream stream;
  std::array<int, MarkovChain::kMostOrder> past = {};  ///< kinds, the latest last
  int past_count = 0;
  std::optional<EventKind> planned;
  Eigen::Index followed = -1;  ///< the segment whose coefficients it has, or moves to
  double released = 0.0;       ///< s, the crowd's time at its release
};

/// Steps that bodies take pack by pack.
constexpr std::size_t kBlock = 4;

void require_finite_numbers(std::span<const double> numbers, const char* what) {
  for (const double number : numbers) {
    if (!std::isfinite(number))
      throw ArgumentError(fmt::format("{} has the number {}, expected finite ones", what, number));
  }
}

}  // namespace

struct Bodies::Impl {
  Impl(const NextPieces& source, Eigen::Index count, const BodiesOptions& given)
      : pieces(source),
        options(given),
        model(steered_model(source.database(), given.wind != nullptr)),
        moving(source.tree().moving_states()),
        layout(moving.layout()),
        stepper(model, source.database().coefficient_names, count, {.driven = driven_names(source, model)}),
        states(static_cast<std::size_t>(model.state_count())),
        coefficients(source.database().coefficient_names.size()),
        width(static_cast<std::size_t>(stepper.width())),
        finders(moving, source.database().events, count, width),
        before(states * width),
        relative(given.wind ? states * width : 0),
        values(static_cast<std::size_t>(model.free_count())),
        state(states),
        present(coefficients) {
    bodies.reserve(static_cast<std::size_t>(count));
    for (Eigen::Index n = 0; n < count; ++n) bodies.emplace_back(given.seed, static_cast<std::uint64_t>(n));
    if (given.wind) air.emplace(model.model(), given.wind, layout, bodies.size());
    room = bodies.size() * 4;
    events.reserve(room);
    for (std::vector<BodyEvent>& of_step : fresh) of_step.reserve(bodies.size());
    const models::ModelInfo& info = model.model().info();
    pose = *models::pose_states_of(info);
    for (const std::string& name : pose.names)
      pose_indices.push_back(static_cast<std::size_t>(
          std::ranges::find(info.states, name, &models::StateInfo::name) - info.states.begin()));
    if (options.step == 0.0) options.step = source.database().step;
    if (options.ramp < 0.0) options.ramp = source.ramp();
    if (options.tries > 0) ahead.emplace(source, options.step, options.ramp, options.tries);
  }

  /// What of the model's free parameters tells it of the air.
  static std::vector<std::string> driven_names(const NextPieces& source,
                                               const models::ParametricModel& model) {
    std::vector<std::string> names;
    for (std::size_t k = source.database().coefficient_names.size(); k < model.free().size(); ++k)
      names.push_back(model.free()[k].name);
    return names;
  }

  Body& body(Eigen::Index n) { return bodies[static_cast<std::size_t>(n)]; }

  void require_above_ground(Eigen::Index n, double height) const {
    if (!options.ground || height > *options.ground) return;
    throw ArgumentError(fmt::format("body {} starts at a height of {} m, expected above the ground at {} m",
                                    n, height, *options.ground));
  }

  void begin(Eigen::Index n, std::span<const double> from, std::span<const double> first) {
    Body& one = body(n);
    std::ranges::fill(values, 0.0);
    std::ranges::copy(first, values.begin());
    stepper.load(n, values);
    stepper.set_state(n, 0.0, from);
    one.status = BodyStatus::falling;
    one.past_count = 0;
    one.planned.reset();
    one.followed = -1;
    one.released = time;
    std::ranges::copy(from, state.begin());
    if (air) {
      air->begin(n);
      air->look(n, time, state);
    }
    finders.begin(n, 0.0, state);
  }

  /// Tells a body of the air over the next step, which the model counts from the body's own time.
  void tell_air(Eigen::Index n, double h) {
    stepper.read(n, state);
    air->tell(n, stepper.time(n), h, state, values);
    stepper.drive(n, values);
  }

  /// Steps of all, pack by pack: what a pack needs is at hand then.
  void step(double h, std::size_t steps) {
    for (Eigen::Index p = 0; p < stepper.packs(); ++p) {
      for (std::size_t k = 0; k < steps; ++k) step_pack(p, h, fresh[k]);
    }
    for (std::vector<BodyEvent>& of_step : fresh) {
      const std::size_t count = std::min(of_step.size(), room - events.size());
      events.insert(events.end(), of_step.begin(), of_step.begin() + static_cast<std::ptrdiff_t>(count));
      counts.dropped += static_cast<long>(of_step.size() - count);
      of_step.clear();
    }
  }

  Eigen::Index body_of(Eigen::Index pack, int slot) const { return pack * stepper.width() + slot; }

  void step_pack(Eigen::Index p, double h, std::vector<BodyEvent>& found) {
    const models::Stepper::PackView pack = stepper.pack(p);
    if (pack.running == 0) return;
    for (std::size_t i = 0; i < states; ++i)
      std::copy_n(pack.states + i * pack.stride, width, before.data() + i * width);
    if (air) for_bits(pack.running, [&](int slot) { tell_air(body_of(p, slot), h); });
    stepper.step_pack(p, h);
    std::uint64_t falling = pack.running & stepper.finite_lanes(p);
    for_bits(pack.running & ~falling, [&](int slot) { lose(p, slot); });
    if (options.ground) falling &= ~landed(p, pack, falling);
    LaneRows<const double> seen = {pack.states, pack.stride};
    if (air) seen = relative_states(p, pack, falling);
    for_bits(finders.see(p, pack.times, seen, falling), [&](int slot) { go_on(p, slot, seen, found); });
  }

  LaneRows<const double> relative_states(Eigen::Index p, const models::Stepper::PackView& pack,
                                         std::uint64_t lanes) {
    for_bits(lanes, [&](int slot) {
      const Eigen::Index n = body_of(p, slot);
      stepper.read(n, state);
      air->look(n, body(n).released + pack.times[slot], state);
      for (std::size_t i = 0; i < states; ++i)
        relative[i * width + static_cast<std::size_t>(slot)] = state[i];
    });
    return {relative.data(), width};
  }

  void rest(Eigen::Index n, BodyStatus status, std::span<const double> where) {
    body(n).status = status;
    stepper.set_state(n, stepper.time(n), where);
    stepper.set_running(n, false);
  }

  void read_before(int slot, std::span<double> numbers) const {
    for (std::size_t i = 0; i < states; ++i) numbers[i] = before[i * width + static_cast<std::size_t>(slot)];
  }

  /// It rests where it was last.
  void lose(Eigen::Index p, int slot) {
    read_before(slot, state);
    rest(body_of(p, slot), BodyStatus::not_finite, state);
  }

  /// Those that have come to the ground rest where their way met it. @returns which
  std::uint64_t landed(Eigen::Index p, const models::Stepper::PackView& pack, std::uint64_t lanes) {
    const double* height = pack.states + layout.positions().back() * pack.stride;
    std::uint64_t down = 0;
    for_bits(lanes, [&](int slot) {
      if (!(height[slot] <= *options.ground)) return;
      down |= std::uint64_t{1} << slot;
      const Eigen::Index n = body_of(p, slot);
      read_before(slot, state);
      const Eigen::Vector3d from = layout.place(state);
      stepper.read(n, state);
      const Eigen::Vector3d place = layout.place(state);
      const double drop = from.z() - place.z();
      const double share = drop > 0.0 ? std::clamp((from.z() - *options.ground) / drop, 0.0, 1.0) : 1.0;
      layout.put_place(from + share * (place - from), state);
      rest(n, BodyStatus::landed, state);
    });
    return down;
  }

  /// As in the sequences that chains are made of, what is steady cuts the past.
  static void remember(Body& one, const Event& event) {
    if (event.is_steady) {
      one.past_count = 0;
      return;
    }
    if (one.past_count == MarkovChain::kMostOrder) {
      std::shift_left(one.past.begin(), one.past.end(), 1);
      --one.past_count;
    }
    one.past[static_cast<std::size_t>(one.past_count++)] = static_cast<int>(event.kind);
  }

  /// At an event: the next piece, from the state at it.
  void go_on(Eigen::Index p, int slot, const LaneRows<const double>& seen, std::vector<BodyEvent>& found) {
    const Eigen::Index n = body_of(p, slot);
    Body& one = body(n);
    const Event& event = finders.event(n);
    remember(one, event);
    const std::span<const int> past(one.past.data(), static_cast<std::size_t>(one.past_count));
    const std::span<NextPiece> wanted(choices.data(), static_cast<std::size_t>(std::max(1, options.tries)));
    const std::size_t count = options.choice == BodiesOptions::Choice::chain
                                  ? pieces.after(one.followed, finders.state(n), past, one.stream, wanted)
                                  : pieces.after(one.followed, finders.state(n), one.stream, wanted);
    // Nothing is near a state whose squares are infinite.
    if (count == 0) return lose(p, slot);
    const NextPiece piece = best_of(n, slot, seen, wanted.first(count));
    note({n, event.t, event.kind, event.is_steady, one.planned, piece}, found);
    one.planned = piece.kind;
    one.followed = piece.segment;
    const Eigen::VectorXd& target = pieces.coefficients(piece);
    stepper.ramp(n, {target.data(), coefficients}, options.ramp);
  }

  /// The first that keeps its kind when it is tried, else the first.
  const NextPiece& best_of(Eigen::Index n, int slot, const LaneRows<const double>& seen,
                           std::span<const NextPiece> some) {
    if (!ahead) return some.front();
    for (std::size_t i = 0; i < states; ++i) state[i] = seen.row(i)[slot];
    stepper.read_parameters(n, present);
    const std::size_t first = ahead->first_kept({finders, n, stepper.time(n), state, present}, some);
    return first < some.size() ? some[first] : some.front();
  }

  void note(const BodyEvent& event, std::vector<BodyEvent>& found) {
    ++counts.events;
    if (!event.is_steady) {
      counts.planned += event.planned.has_value();
      counts.kept += event.planned == event.kind;
    }
    counts.drawn += event.next.drawn.has_value();
    counts.taken += event.next.drawn == event.next.kind;
    counts.redrawn += event.next.is_of_chain && event.next.drawn != event.next.kind;
    found.push_back(event);
  }

  const NextPieces& pieces;
  BodiesOptions options;
  models::ParametricModel model;
  MovingStates moving;
  StateLayout layout;
  models::Stepper stepper;
  std::size_t states, coefficients, width;
  EventLanes finders;
  std::vector<Body> bodies;
  double time = 0.0;                     // s, of the crowd: all that it has advanced
  std::optional<AirAboutBodies> air;     // in wind
  std::vector<double> before, relative;  // states of a pack: before its step, and in wind
  std::vector<double> values;            // all free parameters of one body
  std::vector<double> state;             // of one body
  std::optional<LookAhead> ahead;
  std::array<NextPiece, NextPieces::kMost> choices = {};
  std::vector<double> present;                       // coefficients of one body
  std::array<std::vector<BodyEvent>, kBlock> fresh;  // of the steps that are taken now
  std::vector<BodyEvent> events;
  std::size_t room = 0;  // of events
  BodyCounts counts;
  models::PoseStates pose;
  std::vector<std::size_t> pose_indices;
};

Bodies::Bodies(const NextPieces& pieces, Eigen::Index count, const BodiesOptions& options) {
  require(count > 0, "count of bodies", count, "1 or more");
  require_not_negative(options.step, "step of bodies");
  require(std::isfinite(options.ramp), "ramp of bodies", options.ramp, "a finite number");
  const double ground = options.ground.value_or(0.0);
  require(std::isfinite(ground), "ground of bodies", ground, "a finite number");
  constexpr auto kMostTries = static_cast<int>(NextPieces::kMost);
  require(options.tries >= 0 && options.tries <= kMostTries, "tries", options.tries,
          fmt::format("0 to {}", kMostTries));
  impl_ = std::make_unique<Impl>(pieces, count, options);
}
Bodies::~Bodies() = default;
Bodies::Bodies(Bodies&&) noexcept = default;
Bodies& Bodies::operator=(Bodies&&) noexcept = default;

Eigen::Index Bodies::count() const {
  return static_cast<Eigen::Index>(impl_->bodies.size());
}

void Bodies::release(Eigen::Index n, std::span<const double> state, std::span<const double> coefficients) {
  require_index(n);
  if (state.size() != impl_->states || (!coefficients.empty() && coefficients.size() != impl_->coefficients))
    throw ArgumentError(
        fmt::format("a body was released with {} states and {} coefficients, expected {} and {}",
                    state.size(), coefficients.size(), impl_->states, impl_->coefficients));
  require_finite_numbers(state, "the state of a body");
  require_finite_numbers(coefficients, "the coefficients of a body");
  if (!impl_->layout.is_planar) {
    double square = 0.0;
    for (const std::size_t i : impl_->layout.attitudes()) square += state[i] * state[i];
    if (std::abs(std::sqrt(square) - 1.0) > 1e-3)
      throw ArgumentError(
          fmt::format("the quaternion of a body has the length {}, expected 1", std::sqrt(square)));
  }
  impl_->require_above_ground(n, impl_->layout.place(state).z());
  if (!coefficients.empty()) return impl_->begin(n, state, coefficients);
  NearSegment found;
  impl_->pieces.tree().nearest(state, {&found, 1});
  const Eigen::VectorXd& nearest = impl_->pieces.coefficients({found.segment, EventKind::swing_plus, 0.0});
  impl_->begin(n, state, {nearest.data(), static_cast<std::size_t>(nearest.size())});
}

void Bodies::release(Eigen::Index n, const Eigen::Vector3d& place, double yaw) {
  require_index(n);
  const std::array<double, 4> given = {place.x(), place.y(), place.z(), yaw};
  require_finite_numbers(given, "the release of a body");
  Impl& run = *impl_;
  run.require_above_ground(n, place.z());
  const MotionDatabase& database = run.pieces.database();
  const Eigen::Index segment = run.pieces.draw_segment(run.body(n).stream);
  Eigen::VectorXd state = database.starts.row(segment);
  const std::span<double> numbers(state.data(), run.states);
  run.layout.put_place(place, numbers);
  if (!run.layout.is_planar) {
    const auto& at = run.layout.attitude;
    const Eigen::Quaterniond turned =
        Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
        Eigen::Quaterniond(numbers[at[0]], numbers[at[1]], numbers[at[2]], numbers[at[3]]).normalized();
    const std::array<double, 4> q = {turned.w(), turned.x(), turned.y(), turned.z()};
    for (std::size_t k = 0; k < 4; ++k) numbers[at[k]] = q[k];
  }
  if (run.air) run.air->carry(run.time, numbers);
  const Eigen::VectorXd& own = run.pieces.coefficients({segment, EventKind::swing_plus, 0.0});
  run.begin(n, {state.data(), run.states}, {own.data(), run.coefficients});
}

void Bodies::advance(double dt) {
  require_positive(dt, "time to advance");
  impl_->events.clear();
  const double steps = std::max(1.0, std::ceil(dt / impl_->options.step * (1.0 - 1e-12)));
  if (steps > 1e8) throw ArgumentError(fmt::format("{} s take {} steps, expected at most 1e8", dt, steps));
  for (auto left = static_cast<std::size_t>(steps); left > 0;) {
    const std::size_t now = std::min(left, kBlock);
    impl_->step(dt / steps, now);
    left -= now;
  }
  impl_->time += dt;
}

std::span<const BodyEvent> Bodies::events() const {
  return impl_->events;
}

const BodyCounts& Bodies::counts() const {
  return impl_->counts;
}

void Bodies::require_index(Eigen::Index n) const {
  if (n < 0 || n >= count())
    throw ArgumentError(fmt::format("there is no body {}, expected 0 to {}", n, count() - 1));
}

BodyStatus Bodies::status(Eigen::Index n) const {
  require_index(n);
  return impl_->body(n).status;
}

Eigen::Index Bodies::falling() const {
  return std::ranges::count(impl_->bodies, BodyStatus::falling, &Body::status);
}

double Bodies::time(Eigen::Index n) const {
  require_index(n);
  return impl_->stepper.time(n);
}

void Bodies::read_state(Eigen::Index n, std::span<double> state) const {
  require_index(n);
  if (state.size() != impl_->states)
    throw ArgumentError(fmt::format("{} states were asked for, expected {}", state.size(), impl_->states));
  if (impl_->body(n).status == BodyStatus::waiting) {
    std::ranges::fill(state, 0.0);
  } else {
    impl_->stepper.read(n, state);
  }
}

void Bodies::read_coefficients(Eigen::Index n, std::span<double> coefficients) const {
  require_index(n);
  if (coefficients.size() != impl_->coefficients)
    throw ArgumentError(
        fmt::format("{} coefficients were asked for, expected {}", coefficients.size(), impl_->coefficients));
  impl_->stepper.read_parameters(n, coefficients);
}

void Bodies::read_poses(std::span<double> positions, std::span<double> rotations) const {
  const auto bodies = static_cast<std::size_t>(count());
  if (positions.size() != 3 * bodies || rotations.size() != 4 * bodies)
    throw ArgumentError(fmt::format("there is room for {} and {} numbers, expected {} and {}",
                                    positions.size(), rotations.size(), 3 * bodies, 4 * bodies));
  std::array<double, 7> numbers = {};
  models::Stepper::PackView pack;
  for (std::size_t n = 0; n < bodies; ++n) {
    const std::size_t slot = n % impl_->width;
    if (slot == 0) pack = impl_->stepper.pack(static_cast<Eigen::Index>(n / impl_->width));
    models::BodyPose pose;
    if (impl_->bodies[n].status != BodyStatus::waiting) {
      for (std::size_t k = 0; k < impl_->pose_indices.size(); ++k)
        numbers[k] = pack.states[impl_->pose_indices[k] * pack.stride + slot];
      pose = impl_->pose.pose(std::span(numbers).first(impl_->pose_indices.size()));
    }
    std::ranges::copy(pose.p_WB, positions.begin() + static_cast<std::ptrdiff_t>(3 * n));
    std::ranges::copy(pose.q_WB, rotations.begin() + static_cast<std::ptrdiff_t>(4 * n));
  }
}

}  // namespace samara::motion
