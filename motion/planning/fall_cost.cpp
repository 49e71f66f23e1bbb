#include "samara/motion/planning/fall_cost.h"

#include <algorithm>
#include <cmath>

#include "samara/models/stochastic/turbulent_action.h"

namespace samara::motion {

namespace {

/// Constant of the Langevin equation, C_0.
constexpr double kKolmogorov = 2.1;
/// Constant of changes, before the mean over coefficients.
constexpr double kChangeCost = 0.06;

double square(double x) {
  return x * x;
}

/// The mean price of segments, so that falls with fewer of them are no cheaper; what a fall that is
/// over has not reached was not as asked.
double price_of_kinds(const PlannedFall& fall, const FallPoint& point) {
  const auto& sequence = fall.plan().sequence;
  if (!sequence) return 0.0;
  const double asked = static_cast<double>(sequence->segments.size());
  const double segments = std::max(0, point.events - 1);
  const double missing = fall.is_over(point.t, point.height) ? std::max(0.0, asked - segments) : 0.0;
  const double counted = (sequence->chain ? segments : std::min(segments, asked)) + missing;
  if (counted == 0.0) return 0.0;
  const double price = sequence->is_of_patterns() ? MotionSequence::kUnseenPrice : 1.0;
  return sequence->weight * (point.kinds + price * missing) / counted;
}

}  // namespace

double height_fallen(const PlannedFall& fall, double height) {
  const double a = fall.semi_length();
  return std::max(a, fall.release_height() - height) / a;
}

double deviation_weight(const PlannedFall& fall, double duration, double t) {
  return std::sqrt(duration / std::max(1e-300, t)) / fall.semi_length();
}

double change_weight(const PlannedFall& fall, std::size_t coefficient) {
  const SteeredCoefficient& range = fall.plan().box[coefficient];
  return std::sqrt(kChangeCost / static_cast<double>(fall.names().size())) / (range.upper - range.lower);
}

double turbulence_weight(const PlannedFall& fall, double duration, double fallen) {
  return std::sqrt(fall.turbulence_factor() * duration * std::abs(fallen) / fall.semi_length());
}

double landing_weight(const PlannedFall& fall) {
  return 1.0 / fall.semi_length();
}

FallCost cost_of(const PlannedFall& fall, const FallPoint& point) {
  const MotionPlan& plan = fall.plan();
  const double fallen = height_fallen(fall, point.height);
  FallCost cost;
  cost.path = point.square_time * square(deviation_weight(fall, 1.0, point.t));
  cost.changes = point.changes / fallen;
  cost.turbulence = point.turbulence / fallen;
  cost.kinds = price_of_kinds(fall, point);
  if (!plan.landing || point.height > plan.ground) return cost;
  const Eigen::Vector3d off = fall.states().position(point.state) - *plan.landing;
  cost.landing = off.head<2>().squaredNorm() * square(landing_weight(fall));
  return cost;
}

void add_change(const PlannedFall& fall, FallPoint& point, const std::vector<double>& from,
                const std::vector<double>& to) {
  for (std::size_t j = 0; j < from.size(); ++j)
    point.changes += square(change_weight(fall, j) * (to[j] - from[j]));
}

double turbulence_factor(const MotionPlan& plan) {
  if (!(plan.turbulence > 0.0)) return 0.0;
  const double k = 1.5 * std::pow(plan.turbulence * plan.scales().velocity, 2);
  const double dissipation = std::pow(0.09, 0.75) * std::pow(k, 1.5) / (0.07 * 2.0 * plan.semi_length());
  // Of an acceleration of 1 m/s^2 that is held for 1 s: the action goes with its square and its duration. What
  // turbulence does by itself costs 3/2 there, and 1 here.
  const models::Turbulence energy{.k = k, .epsilon = dissipation};
  return models::turbulent_action(Eigen::Vector3d::UnitX(), 1.0, energy, {.C_0 = kKolmogorov}) / 1.5;
}

void add_piece(const PlannedFall& fall, FallPoint& point, double duration, double fallen) {
  point.turbulence += point.acceleration_square * square(turbulence_weight(fall, duration, fallen));
}

void add_event(const PlannedFall& fall, FallPoint& point, std::optional<EventKind> kind) {
  const auto& sequence = fall.plan().sequence;
  if (!sequence) return;
  // What ends with the first event is a release, and no segment.
  if (point.events++ == 0) return;
  const auto number = static_cast<std::size_t>(point.events) - 2;
  point.kinds += sequence->price(number, point.past, kind);
  if (!kind) return point.past.clear();
  if (std::ssize(point.past) == MarkovChain::kMostOrder) point.past.erase(point.past.begin());
  point.past.push_back(static_cast<int>(*kind));
}

}  // namespace samara::motion
