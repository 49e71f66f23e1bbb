#include "samara/motion/bodies/bodies.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/batch/stepper.h"
#include "samara/models/bodies/body_pose.h"
#include "samara/models/stochastic/gust_layout.h"
#include "samara/motion/bodies/look_ahead.h"
#include "samara/motion/bodies/steered_model.h"

namespace samara::motion {

namespace {

/// What is remembered of one body.
struct Body {
  Body(const EventFinder& empty, std::uint64_t seed, std::uint64_t number)
      : finder(empty), stream(seed, number) {}

  BodyStatus status = BodyStatus::waiting;
  EventFinder finder;
  Stream stream;
  std::array<int, MarkovChain::kMostOrder> past = {};  ///< kinds, the latest last
  int past_count = 0;
  std::optional<EventKind> planned;
  Eigen::Index followed = -1;                         ///< the segment whose coefficients it has, or moves to
  models::AmbientSample air;                          ///< where it is now
  Eigen::Vector3d carried = Eigen::Vector3d::Zero();  ///< m, how far the air about it has gone
};

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
        current(static_cast<std::size_t>(count) * states, 0.0),
        last_place(static_cast<std::size_t>(count) * 3, 0.0),
        values(static_cast<std::size_t>(model.free_count())),
        relative(states),
        read(states),
        present(coefficients) {
    const EventFinder empty(moving, source.database().events);
    bodies.reserve(static_cast<std::size_t>(count));
    for (Eigen::Index n = 0; n < count; ++n)
      bodies.emplace_back(empty, given.seed, static_cast<std::uint64_t>(n));
    room = static_cast<std::size_t>(count) * 4;
    events.reserve(room);
    const models::ModelInfo& info = model.model().info();
    pose = *models::pose_states_of(info);
    for (const std::string& name : pose.names)
      pose_indices.push_back(static_cast<std::size_t>(
          std::ranges::find(info.states, name, &models::StateInfo::name) - info.states.begin()));
    if (given.wind) gusts.emplace(model.model());
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
  static std::span<double> part_of(std::vector<double>& all, Eigen::Index n, std::size_t size) {
    return std::span(all).subspan(static_cast<std::size_t>(n) * size, size);
  }
  std::span<double> state_of(Eigen::Index n) { return part_of(current, n, states); }
  Eigen::Map<Eigen::Vector3d> last_of(Eigen::Index n) {
    return Eigen::Map<Eigen::Vector3d>(last_place.data() + 3 * n);
  }

  /// Of the world, along the axes of states: in a plane x and z.
  double along_axis(const Eigen::Vector3d& v, std::size_t k) const {
    return v[layout.is_planar && k == 1 ? 2 : static_cast<Eigen::Index>(k)];
  }

  models::BodyOnPath motion_of(std::span<const double> state) const {
    models::BodyOnPath motion;
    gusts->read([&](int i) { return state[static_cast<std::size_t>(i)]; }, motion);
    return motion;
  }

  /// The state with place and velocity relative to the air, in which it meets events and looks for pieces.
  std::span<const double> seen_state(Eigen::Index n) {
    const std::span<double> state = state_of(n);
    if (!options.wind) return state;
    Body& one = body(n);
    const models::BodyOnPath motion = motion_of(state);
    one.air = options.wind->sample(stepper.time(n), motion.position);
    std::ranges::copy(state, relative.begin());
    const Eigen::Vector3d along = motion.attitude.transpose() * one.air.velocity;
    for (std::size_t k = 0; k < layout.velocities().size(); ++k) {
      relative[layout.velocity[k]] -= along_axis(along, k);
      relative[layout.position[k]] -= along_axis(one.carried, k);
    }
    return relative;
  }

  void begin(Eigen::Index n, std::span<const double> state, std::span<const double> first) {
    Body& one = body(n);
    std::ranges::fill(values, 0.0);
    std::ranges::copy(first, values.begin());
    stepper.load(n, values);
    stepper.set_state(n, 0.0, state);
    std::ranges::copy(state, state_of(n).begin());
    one.status = BodyStatus::falling;
    one.finder.restart();
    one.past_count = 0;
    one.planned.reset();
    one.followed = -1;
    one.carried.setZero();
    last_of(n) = layout.place(state);
    one.finder.see(0.0, seen_state(n));
  }

  /// The air over the next step.
  void set_air(Eigen::Index n, double h) {
    Body& one = body(n);
    const models::AmbientSample& air = one.air;
    one.carried += h * air.velocity;
    const Eigen::Vector3d rate = air.rate + air.gradient * motion_of(state_of(n)).velocity;
    const Eigen::Vector3d material = air.rate + air.gradient * air.velocity;
    std::size_t next = 0;
    gusts->write([&](int, double value) { values[next++] = value; }, stepper.time(n), air.velocity, rate,
                 material, Eigen::Vector3d::Zero());
    stepper.drive(n, values);
  }

  void step(double h) {
    const Eigen::Index count = static_cast<Eigen::Index>(bodies.size());
    if (options.wind) {
      for (Eigen::Index n = 0; n < count; ++n) {
        if (body(n).status == BodyStatus::falling) set_air(n, h);
      }
    }
    stepper.step(h);
    for (Eigen::Index n = 0; n < count; ++n) {
      if (body(n).status == BodyStatus::falling) look(n);
    }
  }

  /// What has become of a body.
  void look(Eigen::Index n) {
    Body& one = body(n);
    stepper.read(n, read);
    if (!std::ranges::all_of(read, [](double x) { return std::isfinite(x); }))
      return rest(n, BodyStatus::not_finite);
    std::ranges::copy(read, state_of(n).begin());
    const Eigen::Vector3d place = layout.place(state_of(n));
    if (options.ground && place.z() <= *options.ground) return land(n, place);
    last_of(n) = place;
    if (one.finder.see(stepper.time(n), seen_state(n))) go_on(n);
  }

  void rest(Eigen::Index n, BodyStatus status) {
    body(n).status = status;
    stepper.set_running(n, false);
  }

  /// It rests where its way met the ground.
  void land(Eigen::Index n, const Eigen::Vector3d& place) {
    const Eigen::Vector3d before = last_of(n);
    const double drop = before.z() - place.z();
    const double share = drop > 0.0 ? std::clamp((before.z() - *options.ground) / drop, 0.0, 1.0) : 1.0;
    layout.put_place(before + share * (place - before), state_of(n));
    rest(n, BodyStatus::landed);
  }

  /// At an event: the next piece, from the state at it.
  void go_on(Eigen::Index n) {
    Body& one = body(n);
    const Event& event = one.finder.event();
    if (one.past_count == MarkovChain::kMostOrder) {
      std::shift_left(one.past.begin(), one.past.end(), 1);
      --one.past_count;
    }
    one.past[static_cast<std::size_t>(one.past_count++)] = static_cast<int>(event.kind);
    const std::span<const int> past(one.past.data(), static_cast<std::size_t>(one.past_count));
    const std::span<NextPiece> wanted(choices.data(), static_cast<std::size_t>(std::max(1, options.tries)));
    const std::size_t count = options.choice == BodiesOptions::Choice::chain
                                  ? pieces.after(one.followed, one.finder.state(), past, one.stream, wanted)
                                  : pieces.after(one.followed, one.finder.state(), one.stream, wanted);
    const NextPiece piece = best_of(n, wanted.first(count));
    note({n, event.t, event.kind, one.planned, piece});
    one.planned = piece.kind;
    one.followed = piece.segment;
    const Eigen::VectorXd& target = pieces.coefficients(piece);
    stepper.ramp(n, {target.data(), coefficients}, options.ramp);
  }

  /// The first that keeps its kind when it is tried, else the first.
  const NextPiece& best_of(Eigen::Index n, std::span<const NextPiece> some) {
    if (!ahead) return some.front();
    stepper.read_parameters(n, present);
    const std::span<const double> state = options.wind ? std::span<const double>(relative) : state_of(n);
    const std::size_t first = ahead->first_kept({body(n).finder, stepper.time(n), state, present}, some);
    return first < some.size() ? some[first] : some.front();
  }

  void note(const BodyEvent& event) {
    ++counts.events;
    counts.planned += event.planned.has_value();
    counts.kept += event.planned == event.kind;
    counts.drawn += event.next.drawn.has_value();
    counts.taken += event.next.drawn == event.next.kind;
    counts.redrawn += event.next.is_of_chain && event.next.drawn != event.next.kind;
    if (events.size() < room) {
      events.push_back(event);
    } else {
      ++counts.dropped;
    }
  }

  const NextPieces& pieces;
  BodiesOptions options;
  models::ParametricModel model;
  MovingStates moving;
  StateLayout layout;
  std::optional<models::GustLayout> gusts;  // in wind
  models::Stepper stepper;
  std::size_t states, coefficients;
  std::vector<Body> bodies;
  std::vector<double> current;         // states, as they are now
  std::vector<double> last_place;      // before the last step
  std::vector<double> values;          // all free parameters of one body
  std::vector<double> relative, read;  // states
  std::optional<LookAhead> ahead;
  std::array<NextPiece, NextPieces::kMost> choices = {};
  std::vector<double> present;  // coefficients of one body
  std::vector<BodyEvent> events;
  std::size_t room = 0;  // of events
  BodyCounts counts;
  models::PoseStates pose;
  std::vector<std::size_t> pose_indices;
};

Bodies::Bodies(const NextPieces& pieces, Eigen::Index count, const BodiesOptions& options) {
  require(count > 0, "count of bodies", count, "1 or more");
  if (!(options.step >= 0.0) || !std::isfinite(options.step) || !std::isfinite(options.ramp) ||
      !std::isfinite(options.ground.value_or(0.0)))
    throw ArgumentError(fmt::format(
        "step, ramp or ground of bodies is {}, {}, {}, expected finite numbers, the step 0 or more",
        options.step, options.ramp, options.ground.value_or(0.0)));
  if (options.tries < 0 || options.tries > static_cast<int>(NextPieces::kMost))
    throw ArgumentError(
        fmt::format("{} tries were asked for, expected 0 to {}", options.tries, NextPieces::kMost));
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
  if (run.options.wind) {
    const models::BodyOnPath motion = run.motion_of(numbers);
    const Eigen::Vector3d along =
        motion.attitude.transpose() * run.options.wind->sample(0.0, motion.position).velocity;
    for (std::size_t k = 0; k < run.layout.velocities().size(); ++k)
      numbers[run.layout.velocity[k]] += run.along_axis(along, k);
  }
  const Eigen::VectorXd& own = run.pieces.coefficients({segment, EventKind::swing_plus, 0.0});
  run.begin(n, {state.data(), run.states}, {own.data(), run.coefficients});
}

void Bodies::advance(double dt) {
  require_positive(dt, "time to advance");
  impl_->events.clear();
  const double steps = std::max(1.0, std::ceil(dt / impl_->options.step * (1.0 - 1e-12)));
  if (steps > 1e8) throw ArgumentError(fmt::format("{} s take {} steps, expected at most 1e8", dt, steps));
  for (long k = 0; k < static_cast<long>(steps); ++k) impl_->step(dt / steps);
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
  std::ranges::copy(impl_->state_of(n), state.begin());
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
  for (std::size_t n = 0; n < bodies; ++n) {
    models::BodyPose pose;
    if (impl_->bodies[n].status != BodyStatus::waiting) {
      const std::span<const double> state = impl_->state_of(static_cast<Eigen::Index>(n));
      for (std::size_t k = 0; k < impl_->pose_indices.size(); ++k) numbers[k] = state[impl_->pose_indices[k]];
      pose = impl_->pose.pose(std::span(numbers).first(impl_->pose_indices.size()));
    }
    std::ranges::copy(pose.p_WB, positions.begin() + static_cast<std::ptrdiff_t>(3 * n));
    std::ranges::copy(pose.q_WB, rotations.begin() + static_cast<std::ptrdiff_t>(4 * n));
  }
}

}  // namespace samara::motion
