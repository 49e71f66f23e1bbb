#include "samara/motion/planning/fall_lanes.h"

#include <algorithm>
#include <cmath>

#include "samara/base/bits.h"
#include "samara/base/errors.h"
#include "samara/base/smoothstep.h"
#include "samara/motion/planning/fall_cost.h"

namespace samara::motion {

namespace {

constexpr Eigen::Index kLanes = 32;
/// Semi-lengths over the velocity scale from decision to decision, at most.
constexpr double kLongestPiece = 8.0;
/// The same between looks, at most, where steps are shorter.
constexpr double kLook = 0.02;

std::vector<std::string> names_of(const MotionPlan& plan) {
  std::vector<std::string> names;
  for (const SteeredCoefficient& coefficient : plan.box) names.push_back(coefficient.name);
  return names;
}

models::ParametricModel model_of(const MotionPlan& plan) {
  std::map<std::string, double> fixed = plan.fixed;
  for (const SteeredCoefficient& coefficient : plan.box) fixed.erase(coefficient.name);
  return {plan.model, fixed, names_of(plan)};
}

std::vector<double> natural_of(const MotionPlan& plan) {
  std::vector<double> natural;
  for (const SteeredCoefficient& coefficient : plan.box) natural.push_back(coefficient.natural);
  return natural;
}

std::vector<double> release_state(const MotionPlan& plan) {
  const models::ParametricModel natural(plan.model, plan.fixed, {});
  std::vector<double> state(static_cast<std::size_t>(natural.state_count()));
  natural.initial({}, state);
  return state;
}

/// Events are those of the database, or those of a motion at the velocity scale.
EventFinder finder_of(const MotionPlan& plan) {
  const double speed = plan.scales().velocity;
  return {MovingStates(plan.model->info(), BodySymmetry::none),
          plan.database ? plan.database->events : event_options(speed * speed, 2.0 * plan.semi_length())};
}

}  // namespace

double MotionPlan::semi_length() const {
  const models::ParametricModel parametric(model, fixed, {});
  const double semi = 0.5 * motion::MotionStates::body_length(*model, parametric.parameters({}));
  return semi > 0.0 ? semi : parametric.scales({}).length;
}

models::Scales MotionPlan::scales() const {
  return models::ParametricModel(model, fixed, {}).scales({});
}

double MotionPlan::release_height() const {
  return MotionStates(model->info()).position(release_state(*this)).z();
}

bool MotionPlan::starts_at_rest() const {
  const std::vector<double> state = release_state(*this);
  const MovingStates moving(model->info(), BodySymmetry::none);
  const auto rests = [&](std::size_t i) { return state[i] == 0.0; };
  return std::ranges::all_of(moving.layout().velocities(), rests) &&
         std::ranges::all_of(moving.layout().rates(), rests);
}

double MotionPlan::steps() const {
  const double speed = scales().velocity;
  double time = std::max(0.0, release_height() - ground) / speed;
  if (duration) time = std::min(time, *duration);
  return std::max(time, kLongestPiece * semi_length() / speed) / search.step;
}

bool MotionPlan::sinks() const {
  const models::ParametricModel natural(model, fixed, {});
  std::vector<double> state = release_state(*this), rate(state.size());
  const MovingStates moving(model->info(), BodySymmetry::none);
  for (const std::size_t i : moving.layout().velocities()) state[i] = 0.0;
  for (const std::size_t i : moving.layout().rates()) state[i] = 0.0;
  auto workspace = natural.make_workspace();
  natural.rhs(0.0, state, {}, rate, workspace);
  // At rest the rates of the velocities along body axes are the acceleration: in the place of these it is turned alike.
  for (const std::size_t i : moving.layout().velocities()) state[i] = rate[i];
  return moving.at(state).velocity.z() < 0.0;
}

PlannedFall::PlannedFall(const MotionPlan& plan)
    : plan_(plan),
      names_(names_of(plan)),
      natural_(natural_of(plan)),
      model_(model_of(plan)),
      states_(plan.model->info()),
      semi_length_(plan.semi_length()),
      longest_piece_(kLongestPiece * semi_length_ / plan.scales().velocity),
      turbulence_factor_(motion::turbulence_factor(plan)),
      steps_to_look_(static_cast<int>(std::clamp(
          kLook * semi_length_ / plan.scales().velocity / plan.search.step * (1.0 + 1e-9), 1.0, 1e9))),
      finder_(finder_of(plan)) {
  release_height_ = release().height;
  if (plan.database) choices_.emplace(plan);
  if (!plan.landing || plan.sketch) return;
  const Eigen::Vector3d start = states_.position(release().state);
  if (!(start.z() > plan.ground)) return;
  Eigen::MatrixX3d ends(2, 3);
  ends << start.transpose(), plan.landing->x(), plan.landing->y(), plan.ground;
  way_ = Sketch(ends);
}

FallPoint PlannedFall::release() const {
  FallPoint point;
  point.state.resize(static_cast<std::size_t>(model_.state_count()));
  model_.initial(natural_, point.state);
  point.coefficients = natural_;
  point.heading_for = natural_;
  const Eigen::Vector3d place = states_.position(point.state);
  point.height = place.z();
  point.deviation = deviation(0.0, place);
  return point;
}

bool PlannedFall::is_over(double t, double height) const {
  return height <= plan_.ground || (plan_.duration && t >= *plan_.duration);
}

const AskedSegment* PlannedFall::asked(const FallPoint& point) const {
  const auto number = static_cast<std::size_t>(point.events) - 1;
  if (!plan_.sequence || point.events < 1 || number >= plan_.sequence->segments.size()) return nullptr;
  return &plan_.sequence->segments[number];
}

Eigen::Vector3d PlannedFall::deviation(double t, const Eigen::Vector3d& position, Eigen::Index& near) const {
  if (!plan_.sketch) return Eigen::Vector3d::Zero();
  return position - plan_.sketch->target(t, position, near);
}

Eigen::Vector3d PlannedFall::off_course(const FallPoint& point) const {
  if (!way_) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d place = states_.position(point.state);
  return place - way_->target(point.t, place);
}

Roaming::Roaming(const PlannedFall& fall)
    : fall_(fall),
      rate_(static_cast<std::size_t>(fall.model().state_count())),
      natural_rate_(rate_.size()),
      workspace_(fall.model().make_workspace()) {}

void Roaming::at(double t, std::span<const double> state, std::span<const double> coefficients,
                 Eigen::VectorXd& difference) {
  fall_.model().rhs(t, state, coefficients, rate_, workspace_);
  fall_.model().rhs(t, state, fall_.natural(), natural_rate_, workspace_);
  const auto places = fall_.finder().moving_states().layout().velocities();
  difference.resize(static_cast<Eigen::Index>(places.size()));
  for (std::size_t k = 0; k < places.size(); ++k)
    difference[static_cast<Eigen::Index>(k)] = rate_[places[k]] - natural_rate_[places[k]];
}

/// What looks have added up.
struct FallLanes::Sums {
  double square_time = 0.0;
  Eigen::Vector3d deviation = Eigen::Vector3d::Zero();
  int roamings = 0;
  double roaming = 0.0;  ///< sum over these
};

struct FallLanes::Rider {
  std::size_t number = 0;
  const Continuation* continuation = nullptr;
  Sums sums, before;      ///< now, and at the look before
  Eigen::Index near = 0;  ///< point of the sketch that comes next
  int steps = 0;
  FallPoint slowest;  ///< the look beside what may turn out to be an event
  FallPiece piece;    ///< once it has ended
};

FallLanes::FallLanes(const PlannedFall& fall)
    : fall_(fall),
      stepper_(fall.model(), fall.names(), kLanes),
      finders_(fall.finder().moving_states(), fall.finder().options(), kLanes,
               static_cast<std::size_t>(stepper_.width())),
      riders_(static_cast<std::size_t>(kLanes)),
      state_(static_cast<std::size_t>(fall.model().state_count())),
      roaming_(fall) {
  for (Eigen::Index lane = 0; lane < kLanes; ++lane) {
    stepper_.load(lane, fall.natural());
    stepper_.set_running(lane, false);
  }
}

FallLanes::~FallLanes() = default;

void FallLanes::board(Rider& rider, Eigen::Index lane, const Continuation& continuation) {
  const FallPoint& from = *continuation.from;
  stepper_.set_state(lane, from.t, from.state);
  stepper_.set_parameters(lane, from.coefficients);
  stepper_.ramp(lane, continuation.target, fall_.plan().search.ramp);
  rider.continuation = &continuation;
  rider.sums = {.square_time = from.square_time, .deviation = from.deviation};
  rider.steps = 0;
  finders_.begin(lane, from.t, from.state);
}

/// Into what is there already. The state is that in state_, the sums are the last ones.
void FallLanes::put_point(const Sums& sums, double t, FallPoint& point) const {
  point.t = t;
  point.state = state_;
  point.height = fall_.states().position(state_).z();
  point.square_time = sums.square_time;
  point.deviation = sums.deviation;
  point.acceleration_square = sums.roamings > 0 ? sums.roaming / sums.roamings : 0.0;
}

/// What they were at the time of the point, on the ramp of the piece.
void FallLanes::put_coefficients(const Rider& rider, FallPoint& point) const {
  const FallPoint& from = *rider.continuation->from;
  point.heading_for = rider.continuation->target;
  point.coefficients = from.coefficients;
  const double share = smoothstep((point.t - from.t) / fall_.plan().search.ramp);
  for (std::size_t j = 0; j < point.coefficients.size(); ++j)
    point.coefficients[j] = gone(from.coefficients[j], point.heading_for[j], share);
}

void FallLanes::add_look(Rider& rider, double t, const Eigen::Vector3d& place) {
  rider.before = rider.sums;
  Sums& sums = rider.sums;
  sums.deviation = fall_.deviation(t, place, rider.near);
  const int steps = fall_.steps_to_look();
  sums.square_time += 0.5 * steps * fall_.plan().search.step *
                      (rider.before.deviation.squaredNorm() + sums.deviation.squaredNorm());
  rider.steps += steps;
  if (!(fall_.plan().turbulence > 0.0) || rider.steps <= sums.roamings * kBetweenLooks) return;
  roaming_.at(t, state_, rider.continuation->target, difference_);
  sums.roaming += difference_.squaredNorm();
  ++sums.roamings;
}

bool FallLanes::look(Rider& rider, Eigen::Index lane, bool is_finite, bool is_event) {
  stepper_.read(lane, state_);
  const double t = stepper_.time(lane);
  const Eigen::Vector3d place = fall_.states().position(state_);
  add_look(rider, t, place);
  if (!is_finite) return end_piece(rider, lane, FallEnd::not_finite);
  if (finders_.proposes(lane)) {
    const double before = finders_.read_before(lane, state_);
    put_point(rider.before, before, rider.slowest);
    stepper_.read(lane, state_);
  }
  if (fall_.is_over(t, place.z())) return end_piece(rider, lane, FallEnd::ground);
  if (is_event) {
    end_piece(rider, lane, FallEnd::decision);
    rider.piece.has_event = true;
    if (finders_.event(lane).is_steady) return true;
    rider.piece.kind = finders_.event(lane).kind;
    rider.piece.to = rider.slowest;
    put_coefficients(rider, rider.piece.to);
    return true;
  }
  // Where kinds are asked for a segment is not cut but by an event.
  const double longest = (fall_.plan().sequence ? 4.0 : 1.0) * fall_.longest_piece();
  if (t - rider.continuation->from->t < longest) return false;
  return end_piece(rider, lane, FallEnd::decision);
}

/// Where it is now.
bool FallLanes::end_piece(Rider& rider, Eigen::Index lane, FallEnd how) const {
  put_point(rider.sums, stepper_.time(lane), rider.piece.to);
  put_coefficients(rider, rider.piece.to);
  rider.piece.end = how;
  rider.piece.has_event = false;
  rider.piece.kind.reset();
  return true;
}

void FallLanes::run(std::span<const Continuation> continuations, std::span<FallPiece> pieces,
                    SharedProgress& progress) {
  std::size_t next = 0, riding = 0;
  // @returns whether there was one left
  const auto board_next = [&](Eigen::Index lane) {
    if (next == continuations.size()) return false;
    Rider& rider = riders_[static_cast<std::size_t>(lane)];
    rider.number = next;
    board(rider, lane, continuations[next++]);
    return true;
  };
  for (Eigen::Index lane = 0; lane < kLanes && board_next(lane); ++lane) ++riding;
  while (riding > 0 && progress.goes_on()) {
    for (Eigen::Index p = 0; p < stepper_.packs(); ++p) {
      const auto [pack, finite, events] =
          finders_.step(stepper_, p, fall_.plan().search.step, fall_.steps_to_look());
      for_bits(pack.running, [&](int slot) {
        const Eigen::Index lane = p * stepper_.width() + slot;
        Rider& rider = riders_[static_cast<std::size_t>(lane)];
        if (!look(rider, lane, has_bit(finite, slot), has_bit(events, slot))) return;
        pieces[rider.number] = rider.piece;
        if (board_next(lane)) return;
        stepper_.set_running(lane, false);
        --riding;
      });
    }
  }
  for (Eigen::Index lane = 0; lane < kLanes; ++lane) stepper_.set_running(lane, false);
}

}  // namespace samara::motion
