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
  double ramp_start = 0.0;                            ///< s
  Eigen::Vector3d carried = Eigen::Vector3d::Zero();  ///< m, how far the air about it has gone
};

/// Which states of the model are what.
struct StateIndices {
  std::vector<int> position;  // x, y, z, or x, y
  int attitude = 0, velocity = 0;
};

int index_of_state(const models::ModelInfo& info, const std::string& name) {
  const auto it = std::ranges::find(info.states, name, &models::StateInfo::name);
  return static_cast<int>(it - info.states.begin());
}

double smooth_share(double s) {
  const double inside = std::clamp(s, 0.0, 1.0);
  return inside * inside * (3.0 - 2.0 * inside);
}

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
        stepper(model, steered_names(model), count),
        states(static_cast<std::size_t>(model.state_count())),
        coefficients(source.database().coefficient_names.size()),
        current(static_cast<std::size_t>(count) * states, 0.0),
        last_place(static_cast<std::size_t>(count) * 3, 0.0),
        from(static_cast<std::size_t>(count) * coefficients, 0.0),
        to(from),
        values(static_cast<std::size_t>(model.free_count())),
        relative(states),
        read(states) {
    const EventFinder empty(moving, source.database().events);
    bodies.reserve(static_cast<std::size_t>(count));
    for (Eigen::Index n = 0; n < count; ++n)
      bodies.emplace_back(empty, given.seed, static_cast<std::uint64_t>(n));
    events.reserve(static_cast<std::size_t>(count) * 4);
    const models::ModelInfo& info = model.model().info();
    pose = *models::pose_states_of(info);
    for (const std::string& name : pose.names)
      pose_indices.push_back(static_cast<std::size_t>(index_of_state(info, name)));
    for (const char* name : {"x", "y", "z"}) {
      if (moving.is_planar() && std::string_view(name) == "z") continue;
      where.position.push_back(index_of_state(info, name));
    }
    where.attitude = index_of_state(info, moving.is_planar() ? "theta" : "qw");
    where.velocity = index_of_state(info, moving.is_planar() ? "vx" : "ux");
    if (options.step == 0.0) options.step = source.database().step;
    if (options.ramp < 0.0) options.ramp = 0.25 * source.median_duration();
  }

  static std::vector<std::string> steered_names(const models::ParametricModel& model) {
    std::vector<std::string> names;
    for (const auto& coordinate : model.free()) names.push_back(coordinate.name);
    return names;
  }

  Body& body(Eigen::Index n) { return bodies[static_cast<std::size_t>(n)]; }
  static std::span<double> part_of(std::vector<double>& all, Eigen::Index n, std::size_t size) {
    return std::span(all).subspan(static_cast<std::size_t>(n) * size, size);
  }
  std::span<double> state_of(Eigen::Index n) { return part_of(current, n, states); }
  std::span<double> from_of(Eigen::Index n) { return part_of(from, n, coefficients); }
  std::span<double> to_of(Eigen::Index n) { return part_of(to, n, coefficients); }
  Eigen::Map<Eigen::Vector3d> last_of(Eigen::Index n) {
    return Eigen::Map<Eigen::Vector3d>(last_place.data() + 3 * n);
  }

  Eigen::Quaterniond attitude_of(std::span<const double> state) const {
    const double* q = state.data() + where.attitude;
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  }
  Eigen::Vector3d place_of(std::span<const double> state) const {
    const auto at = [&](std::size_t k) { return state[static_cast<std::size_t>(where.position[k])]; };
    if (moving.is_planar()) return {at(0), 0.0, at(1)};
    return {at(0), at(1), at(2)};
  }

  /// The state with place and velocity relative to the air, in which it meets events and looks for pieces.
  std::span<const double> seen_state(Eigen::Index n) {
    const std::span<double> state = state_of(n);
    if (!options.wind) return state;
    std::ranges::copy(state, relative.begin());
    const Eigen::Vector3d air = options.wind->sample(stepper.time(n), place_of(state)).velocity;
    const Eigen::Vector3d along = attitude_of(state).conjugate() * air;
    for (int k = 0; k < 3; ++k) {
      relative[static_cast<std::size_t>(where.velocity + k)] -= along[k];
      relative[static_cast<std::size_t>(where.position[static_cast<std::size_t>(k)])] -= body(n).carried[k];
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
    std::ranges::copy(first, from_of(n).begin());
    std::ranges::copy(first, to_of(n).begin());
    one.status = BodyStatus::falling;
    one.finder.restart();
    one.past_count = 0;
    one.planned.reset();
    one.followed = -1;
    one.ramp_start = -options.ramp;
    one.carried.setZero();
    last_of(n) = place_of(state);
    one.finder.see(0.0, seen_state(n));
  }

  /// Coefficients of a ramp of our own.
  double coefficient(Eigen::Index n, std::size_t k, double t) {
    const Body& one = body(n);
    const double share = options.ramp > 0.0 ? smooth_share((t - one.ramp_start) / options.ramp) : 1.0;
    return from_of(n)[k] + share * (to_of(n)[k] - from_of(n)[k]);
  }

  /// The air over the next step, and the coefficients in its middle.
  void set_air(Eigen::Index n, double h) {
    const double t = stepper.time(n);
    const std::span<double> state = state_of(n);
    for (std::size_t k = 0; k < coefficients; ++k) values[k] = coefficient(n, k, t + 0.5 * h);
    const Eigen::Vector3d u(state[static_cast<std::size_t>(where.velocity)],
                            state[static_cast<std::size_t>(where.velocity) + 1],
                            state[static_cast<std::size_t>(where.velocity) + 2]);
    const models::AmbientSample air = options.wind->sample(t, place_of(state));
    body(n).carried += h * air.velocity;
    const Eigen::Vector3d rate = air.rate + air.gradient * (attitude_of(state) * u);
    const Eigen::Vector3d material = air.rate + air.gradient * air.velocity;
    double* gust = values.data() + coefficients;
    *gust++ = t;
    for (const Eigen::Vector3d* vector : {&air.velocity, &rate, &material}) {
      for (int k = 0; k < 3; ++k) *gust++ = (*vector)[k];
    }
    std::fill_n(gust, 3, 0.0);
    stepper.set_parameters(n, values);
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
    const Eigen::Vector3d place = place_of(state_of(n));
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
    const Eigen::Vector3d at = before + share * (place - before);
    const std::span<double> state = state_of(n);
    for (std::size_t k = 0; k < where.position.size(); ++k)
      state[static_cast<std::size_t>(where.position[k])] =
          at[moving.is_planar() && k == 1 ? 2 : static_cast<Eigen::Index>(k)];
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
    const NextPiece piece = options.choice == BodiesOptions::Choice::chain
                                ? pieces.after(one.followed, one.finder.state(), past, one.stream)
                                : pieces.after(one.followed, one.finder.state(), one.stream);
    if (events.size() < events.capacity()) events.push_back({n, event.t, event.kind, one.planned, piece});
    one.planned = piece.kind;
    one.followed = piece.segment;
    const Eigen::VectorXd& target = pieces.coefficients(piece);
    const double t = stepper.time(n);
    for (std::size_t k = 0; k < coefficients; ++k) {
      const double now = coefficient(n, k, t);
      from_of(n)[k] = now;
      to_of(n)[k] = target[static_cast<Eigen::Index>(k)];
    }
    one.ramp_start = t;
    if (!options.wind) stepper.ramp(n, to_of(n), options.ramp);
  }

  const NextPieces& pieces;
  BodiesOptions options;
  models::ParametricModel model;
  MovingStates moving;
  models::Stepper stepper;
  std::size_t states, coefficients;
  std::vector<Body> bodies;
  std::vector<double> current;         // states, as they are now
  std::vector<double> last_place;      // before the last step
  std::vector<double> from, to;        // of the ramps
  std::vector<double> values;          // all free parameters of one body
  std::vector<double> relative, read;  // states
  std::vector<BodyEvent> events;
  models::PoseStates pose;
  std::vector<std::size_t> pose_indices;
  StateIndices where;
};

Bodies::Bodies(const NextPieces& pieces, Eigen::Index count, const BodiesOptions& options) {
  require(count > 0, "count of bodies", count, "1 or more");
  if (!(options.step >= 0.0) || !std::isfinite(options.step) || !std::isfinite(options.ramp) ||
      !std::isfinite(options.ground.value_or(0.0)))
    throw ArgumentError(fmt::format(
        "step, ramp or ground of bodies is {}, {}, {}, expected finite numbers, the step 0 or more",
        options.step, options.ramp, options.ground.value_or(0.0)));
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
  if (!coefficients.empty()) return impl_->begin(n, state, coefficients);
  NearSegment found;
  impl_->pieces.tree().nearest(state, {&found, 1});
  const Eigen::VectorXd& nearest = impl_->pieces.coefficients({found.segment, EventKind::swing_plus, 0.0});
  impl_->begin(n, state, {nearest.data(), static_cast<std::size_t>(nearest.size())});
}

void Bodies::release(Eigen::Index n, const Eigen::Vector3d& place, double yaw) {
  require_index(n);
  const std::array<double, 4> numbers = {place.x(), place.y(), place.z(), yaw};
  require_finite_numbers(numbers, "the release of a body");
  Impl& run = *impl_;
  const MotionDatabase& database = run.pieces.database();
  const Eigen::Index segment = run.pieces.draw_segment(run.body(n).stream);
  Eigen::VectorXd state = database.starts.row(segment);
  if (run.moving.is_planar()) {
    state[run.where.position[0]] = place.x();
    state[run.where.position[1]] = place.z();
  } else {
    for (std::size_t k = 0; k < 3; ++k) state[run.where.position[k]] = place[static_cast<Eigen::Index>(k)];
    const Eigen::Quaterniond turned = Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())) *
                                      run.attitude_of({state.data(), run.states});
    state.segment<4>(run.where.attitude) << turned.w(), turned.x(), turned.y(), turned.z();
    if (run.options.wind) {
      const Eigen::Vector3d air = run.options.wind->sample(0.0, place).velocity;
      state.segment<3>(run.where.velocity) += turned.conjugate() * air;
    }
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
  for (std::size_t k = 0; k < coefficients.size(); ++k)
    coefficients[k] = impl_->coefficient(n, k, impl_->stepper.time(n));
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
