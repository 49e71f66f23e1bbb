#include "samara/motion/planning/fall_lanes.h"

#include <algorithm>
#include <cmath>

#include "samara/base/errors.h"
#include "samara/motion/planning/fall_cost.h"

namespace samara::motion {

namespace {

constexpr Eigen::Index kLanes = 32;
/// Semi-lengths over the velocity scale from decision to decision, at most.
constexpr double kLongestPiece = 8.0;

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

/// Of the body, or of a body in a plane.
std::vector<std::size_t> velocity_places(const models::ModelInfo& info) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < info.states.size(); ++i) {
    const std::string& name = info.states[i].name;
    if (name == "vx" || name == "vy" || name == "ux" || name == "uy" || name == "uz") places.push_back(i);
  }
  return places;
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

double MotionPlan::steps() const {
  const double speed = scales().velocity;
  const models::ParametricModel natural(model, fixed, {});
  std::vector<double> state(static_cast<std::size_t>(natural.state_count()));
  natural.initial({}, state);
  double time = std::max(0.0, MotionStates(model->info()).position(state).z() - ground) / speed;
  if (duration) time = std::min(time, *duration);
  return std::max(time, kLongestPiece * semi_length() / speed) / search.step;
}

bool MotionPlan::sinks() const {
  const models::ParametricModel natural(model, fixed, {});
  const models::ModelInfo& info = model->info();
  std::vector<double> state(static_cast<std::size_t>(natural.state_count())), rate(state.size());
  natural.initial({}, state);
  const std::vector<std::size_t> velocities = velocity_places(info);
  for (std::size_t i = 0; i < state.size(); ++i) {
    const std::string& name = info.states[i].name;
    if (name.starts_with('w') || std::ranges::find(velocities, i) != velocities.end()) state[i] = 0.0;
  }
  auto workspace = natural.make_workspace();
  natural.rhs(0.0, state, {}, rate, workspace);
  // At rest the rates of the velocities along body axes are the acceleration: in the place of these it is turned alike.
  for (const std::size_t i : velocities) state[i] = rate[i];
  return MovingStates(info, BodySymmetry::none).at(state).velocity.z() < 0.0;
}

PlannedFall::PlannedFall(const MotionPlan& plan)
    : plan_(plan),
      names_(names_of(plan)),
      natural_(natural_of(plan)),
      model_(model_of(plan)),
      states_(plan.model->info()),
      velocity_(velocity_places(plan.model->info())),
      semi_length_(plan.semi_length()) {
  const models::Scales scales = plan.scales();
  prominence_ = 0.02 * scales.velocity * scales.velocity;
  longest_piece_ = kLongestPiece * semi_length_ / scales.velocity;
  release_height_ = release().height;
  turbulence_factor_ = motion::turbulence_factor(plan);
  if (plan.database) choices_.emplace(plan);
  if (plan.sequence) {
    const MovingStates moving(plan.model->info(), BodySymmetry::none);
    events_.emplace(moving, plan.database
                                ? plan.database->events
                                : event_options(scales.velocity * scales.velocity, 2.0 * semi_length_));
  }
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

Eigen::Vector3d PlannedFall::deviation(double t, const Eigen::Vector3d& position) const {
  if (!plan_.sketch) return Eigen::Vector3d::Zero();
  return position - plan_.sketch->target(t, position);
}

Eigen::Vector3d PlannedFall::off_course(const FallPoint& point) const {
  if (!way_) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d place = states_.position(point.state);
  return place - way_->target(point.t, place);
}

double PlannedFall::speed_square(std::span<const double> state) const {
  double sum = 0.0;
  for (const std::size_t i : velocity_) sum += state[i] * state[i];
  return sum;
}

SpeedMinimum::Seen SpeedMinimum::look(double speed_square) {
  if (!falling_) {
    high_ = std::max(high_, speed_square);
    if (speed_square > high_ - prominence_) return Seen::nothing;
    falling_ = true;
    low_ = speed_square;
    return Seen::lowest;
  }
  if (speed_square < low_) {
    low_ = speed_square;
    return Seen::lowest;
  }
  return speed_square < low_ + prominence_ ? Seen::nothing : Seen::confirmed;
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
  const std::vector<std::size_t>& places = fall_.velocities();
  difference.resize(static_cast<Eigen::Index>(places.size()));
  for (std::size_t k = 0; k < places.size(); ++k)
    difference[static_cast<Eigen::Index>(k)] = rate_[places[k]] - natural_rate_[places[k]];
}

struct FallLanes::Rider {
  std::size_t number = 0;
  bool rides = false;
  const Continuation* continuation = nullptr;
  double square_time = 0.0;
  Eigen::Vector3d deviation = Eigen::Vector3d::Zero();
  SpeedMinimum minimum{0.0};
  std::optional<EventFinder> events;  ///< in the place of `minimum` where kinds are asked for
  double speed_square = 0.0;
  bool slows = false;
  std::vector<FallPoint> minima;  ///< of the speed, so far; the first `minima_count` of them
  std::size_t minima_count = 0;
  int steps = 0, looks = 0;
  double roaming = 0.0;  ///< sum over the looks
  FallPoint lowest;      ///< the last one; of a piece that has ended, its end
  FallEnd end = FallEnd::decision;
  bool has_event = false;
};

FallLanes::FallLanes(const PlannedFall& fall)
    : fall_(fall),
      stepper_(fall.model(), fall.names(), kLanes),
      state_(static_cast<std::size_t>(fall.model().state_count())),
      roaming_(fall) {
  for (Eigen::Index lane = 0; lane < kLanes; ++lane) {
    stepper_.load(lane, fall.natural());
    stepper_.set_running(lane, false);
  }
}

void FallLanes::board(Rider& rider, Eigen::Index lane, const Continuation& continuation) {
  const FallPoint& from = *continuation.from;
  stepper_.set_state(lane, from.t, from.state);
  stepper_.set_parameters(lane, from.coefficients);
  stepper_.ramp(lane, continuation.target, fall_.plan().search.ramp);
  rider.rides = true;
  rider.continuation = &continuation;
  rider.square_time = from.square_time;
  rider.steps = rider.looks = 0;
  rider.roaming = 0.0;
  rider.deviation = from.deviation;
  rider.has_event = false;
  if (fall_.events()) {
    if (!rider.events) rider.events = fall_.events();
    rider.events->restart();
    rider.events->see(from.t, from.state);
    rider.speed_square = fall_.speed_square(from.state);
    rider.slows = false;
    rider.minima_count = 0;
    return;
  }
  rider.minimum = SpeedMinimum(fall_.prominence());
  rider.minimum.look(fall_.speed_square(from.state));
}

/// Into what is there already: this happens at most steps.
void FallLanes::put_point(const Rider& rider, Eigen::Index lane, FallPoint& point) const {
  point.t = stepper_.time(lane);
  point.state = state_;
  point.coefficients.resize(fall_.names().size());
  stepper_.read_parameters(lane, point.coefficients);
  point.heading_for = rider.continuation->target;
  point.height = fall_.states().position(state_).z();
  point.square_time = rider.square_time;
  point.deviation = rider.deviation;
  point.acceleration_square = rider.looks > 0 ? rider.roaming / rider.looks : 0.0;
}

/// The event lies some steps back: between two of them, at a minimum of the speed that was kept.
bool FallLanes::is_event(Rider& rider, Eigen::Index lane) {
  const double square = fall_.speed_square(state_);
  if (square < rider.speed_square) {
    if (!rider.slows && rider.minima_count == rider.minima.size()) rider.minima.emplace_back();
    put_point(rider, lane, rider.minima[rider.minima_count]);
    rider.slows = true;
  } else if (rider.slows) {
    ++rider.minima_count;
    rider.slows = false;
  }
  rider.speed_square = square;
  if (!rider.events->see(stepper_.time(lane), state_)) return false;
  rider.has_event = true;
  const Event& event = rider.events->event();
  if (event.is_steady || rider.minima_count == 0) {
    put_point(rider, lane, rider.lowest);
    return true;
  }
  const auto apart = [&](const FallPoint& point) { return std::abs(point.t - event.t); };
  rider.lowest = *std::ranges::min_element(std::span(rider.minima).first(rider.minima_count), {}, apart);
  return true;
}

bool FallLanes::is_decided(Rider& rider, Eigen::Index lane) {
  if (rider.events) return is_event(rider, lane);
  const SpeedMinimum::Seen seen = rider.minimum.look(fall_.speed_square(state_));
  if (seen == SpeedMinimum::Seen::lowest) put_point(rider, lane, rider.lowest);
  return seen == SpeedMinimum::Seen::confirmed;
}

bool FallLanes::look(Rider& rider, Eigen::Index lane) {
  stepper_.read(lane, state_);
  const double t = stepper_.time(lane);
  const Eigen::Vector3d place = fall_.states().position(state_);
  const Eigen::Vector3d before = rider.deviation;
  rider.deviation = fall_.deviation(t, place);
  rider.square_time +=
      0.5 * fall_.plan().search.step * (before.squaredNorm() + rider.deviation.squaredNorm());
  if (fall_.plan().turbulence > 0.0 && rider.steps++ % kBetweenLooks == 0) {
    roaming_.at(t, state_, rider.continuation->target, difference_);
    rider.roaming += difference_.squaredNorm();
    ++rider.looks;
  }
  const auto end_here = [&](FallEnd how) {
    put_point(rider, lane, rider.lowest);
    rider.end = how;
    return true;
  };
  if (!stepper_.finite(lane)) return end_here(FallEnd::not_finite);
  if (fall_.is_over(t, place.z())) return end_here(FallEnd::ground);
  if (is_decided(rider, lane)) {
    rider.end = FallEnd::decision;
    return true;
  }
  // Where kinds are asked for the finder ends segments that are steady; this is for what is neither.
  const double longest = (rider.events ? 4.0 : 1.0) * fall_.longest_piece();
  if (t - rider.continuation->from->t < longest) return false;
  return end_here(FallEnd::decision);
}

void FallLanes::run(std::span<const Continuation> continuations, std::span<FallPiece> pieces,
                    SharedProgress& progress) {
  std::vector<Rider> riders(static_cast<std::size_t>(kLanes));
  std::size_t next = 0, riding = 0;
  for (Eigen::Index lane = 0; lane < kLanes && next < continuations.size(); ++lane) {
    Rider& rider = riders[static_cast<std::size_t>(lane)];
    rider.number = next;
    board(rider, lane, continuations[next++]);
    ++riding;
  }
  while (riding > 0 && progress.goes_on()) {
    stepper_.step(fall_.plan().search.step);
    for (Eigen::Index lane = 0; lane < kLanes; ++lane) {
      Rider& rider = riders[static_cast<std::size_t>(lane)];
      if (!rider.rides || !look(rider, lane)) continue;
      FallPiece& piece = pieces[rider.number];
      piece = {.to = rider.lowest, .end = rider.end, .has_event = rider.has_event};
      if (rider.has_event && !rider.events->event().is_steady) piece.kind = rider.events->event().kind;
      if (next < continuations.size()) {
        rider.number = next;
        board(rider, lane, continuations[next++]);
      } else {
        rider.rides = false;
        stepper_.set_running(lane, false);
        --riding;
      }
    }
  }
}

}  // namespace samara::motion
