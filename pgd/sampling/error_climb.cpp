#include "samara/pgd/sampling/error_climb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace samara::pgd {

namespace {

constexpr int kSteps = 10;
constexpr double kFirstStep = 0.1;  // of the box
constexpr double kLeastStep = 2e-3;
constexpr double kLongestStep = 0.3;
constexpr std::array kLengths = {0.5, 1.0, 2.0, 4.0};  // of the steps along a direction

struct Climb {
  Eigen::VectorXd x;
  double error = 0.0;
  double step = kFirstStep;
  bool is_done() const { return step < kLeastStep || !std::isfinite(error); }
};

/// Where climbs may go. Lengths are shares of the widths.
struct Box {
  Eigen::VectorXd lower, width;
  bool moves(Eigen::Index k) const { return width[k] > 0.0; }
  /// From a point, cut short at the borders.
  Eigen::VectorXd advanced(const Eigen::VectorXd& x, const Eigen::VectorXd& way) const {
    const Eigen::VectorXd y = (x + width.cwiseProduct(way)).cwiseMax(lower).cwiseMin(lower + width);
    return (width.array() > 0.0).select(y, x);
  }
  double distance(Eigen::Index k, double from, double to) const { return (to - from) / width[k]; }
  Eigen::VectorXd way(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
    return (width.array() > 0.0).select((to - from).cwiseQuotient(width), 0.0);
  }
};

/// Points of all climbs that go on, asked for together.
class Asked {
 public:
  void add(const Eigen::VectorXd& x) { points_.push_back(x); }
  const Eigen::VectorXd& point(Eigen::Index j) const { return points_[static_cast<std::size_t>(j)]; }
  Eigen::VectorXd errors(const ErrorsAt& errors_at) const {
    Eigen::MatrixXd points(points_.front().size(), static_cast<Eigen::Index>(points_.size()));
    for (Eigen::Index j = 0; j < points.cols(); ++j) points.col(j) = point(j);
    return errors_at(points);
  }

 private:
  std::vector<Eigen::VectorXd> points_;
};

/// Zero errors have a logarithm, too.
double logarithm(double error) {
  return std::log(std::max(error, std::numeric_limits<double>::min()));
}

/// What the two sides of every coordinate say.
struct Slopes {
  Eigen::VectorXd steepest, newton;  ///< directions, of length one and as long as the model says
};

/// @param sides two errors per coordinate: below and above, at points that the box may have cut short
Slopes slopes_of(const Climb& climb, const Box& box, const Asked& asked, const Eigen::VectorXd& sides,
                 Eigen::Index first) {
  const Eigen::Index d = climb.x.size();
  const double middle = logarithm(climb.error);
  Slopes slopes{Eigen::VectorXd::Zero(d), Eigen::VectorXd::Zero(d)};
  for (Eigen::Index k = 0; k < d; ++k) {
    if (!box.moves(k)) continue;
    const double back = box.distance(k, asked.point(first + 2 * k)[k], climb.x[k]);
    const double ahead = box.distance(k, climb.x[k], asked.point(first + 2 * k + 1)[k]);
    const double fall = back > 0.0 ? (middle - logarithm(sides[2 * k])) / back : 0.0;
    const double rise = ahead > 0.0 ? (logarithm(sides[2 * k + 1]) - middle) / ahead : 0.0;
    slopes.steepest[k] = back == 0.0 ? rise : ahead == 0.0 ? fall : 0.5 * (fall + rise);
    const double curvature = back > 0.0 && ahead > 0.0 ? 2.0 * (rise - fall) / (back + ahead) : 0.0;
    slopes.newton[k] =
        curvature < 0.0 ? slopes.steepest[k] / -curvature : std::copysign(climb.step, slopes.steepest[k]);
  }
  if (slopes.newton.norm() > kLongestStep) slopes.newton *= kLongestStep / slopes.newton.norm();
  if (slopes.steepest.norm() > 0.0) slopes.steepest.normalize();
  return slopes;
}

/// Takes the best of some points, if it is better.
void take_best(Climb& climb, const Asked& asked, const Eigen::VectorXd& errors, Eigen::Index first) {
  Eigen::Index best = 0;
  const double error = errors.maxCoeff(&best);
  if (!(error > climb.error)) return;
  climb.x = asked.point(first + best);
  climb.error = error;
}

void step(const std::vector<Climb*>& climbs, const Box& box, const ErrorsAt& errors_at) {
  const Eigen::Index d = box.lower.size();
  Asked sides;
  for (const Climb* climb : climbs) {
    for (Eigen::Index k = 0; k < d; ++k) {
      sides.add(box.advanced(climb->x, -climb->step * Eigen::VectorXd::Unit(d, k)));
      sides.add(box.advanced(climb->x, climb->step * Eigen::VectorXd::Unit(d, k)));
    }
  }
  const Eigen::VectorXd at_sides = sides.errors(errors_at);
  Asked ways;
  std::vector<Climb> before;
  Eigen::Index first = 0;
  for (Climb* climb : climbs) {
    const Slopes slopes = slopes_of(*climb, box, sides, at_sides.segment(first, 2 * d), first);
    before.push_back(*climb);
    for (const double length : kLengths)
      ways.add(box.advanced(climb->x, length * climb->step * slopes.steepest));
    for (const double length : kLengths) ways.add(box.advanced(climb->x, length * slopes.newton));
    take_best(*climb, sides, at_sides.segment(first, 2 * d), first);
    first += 2 * d;
  }
  const Eigen::VectorXd at_ways = ways.errors(errors_at);
  constexpr auto kWays = static_cast<Eigen::Index>(2 * kLengths.size());
  for (std::size_t i = 0; i < climbs.size(); ++i) {
    Climb& climb = *climbs[i];
    const auto place = static_cast<Eigen::Index>(i) * kWays;
    take_best(climb, ways, at_ways.segment(place, kWays), place);
    constexpr double kGain = 1.05;
    const double moved = box.way(before[i].x, climb.x).norm();
    climb.step = climb.error > kGain * before[i].error ? std::clamp(0.5 * moved, kLeastStep, kFirstStep)
                                                       : 0.3 * climb.step;
  }
}

std::vector<Eigen::Index> descending_order(const Eigen::VectorXd& values) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::ranges::stable_sort(order, [&](Eigen::Index a, Eigen::Index b) { return values[a] > values[b]; });
  return order;
}

}  // namespace

bool has_outliers(const Eigen::VectorXd& errors, double times) {
  if (errors.size() == 0) return false;
  std::vector<double> sorted(errors.begin(), errors.end());
  const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(sorted.size()));
  std::nth_element(sorted.begin(), std::min(place, sorted.end() - 1), sorted.end());
  return errors.maxCoeff() > times * *std::min(place, sorted.end() - 1);
}

Climbs climb_errors(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper, const ErrorsAt& errors_at,
                    const Eigen::MatrixXd& starts, const Eigen::VectorXd& errors) {
  const Box box{lower, upper - lower};
  std::vector<Climb> climbs;
  for (Eigen::Index j = 0; j < starts.cols(); ++j) climbs.push_back({starts.col(j), errors[j]});
  for (int i = 0; i < kSteps; ++i) {
    std::vector<Climb*> going;
    for (Climb& climb : climbs) {
      if (!climb.is_done()) going.push_back(&climb);
    }
    if (going.empty()) break;
    step(going, box, errors_at);
  }
  Climbs result{starts, errors};
  for (Eigen::Index j = 0; j < starts.cols(); ++j) {
    result.points.col(j) = climbs[static_cast<std::size_t>(j)].x;
    result.errors[j] = climbs[static_cast<std::size_t>(j)].error;
  }
  return result;
}

Climbs climb_from_worst(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper, const ErrorsAt& errors_at,
                        const Eigen::MatrixXd& points, const Eigen::VectorXd& errors, int count) {
  std::vector<Eigen::Index> order = descending_order(errors);
  order.resize(std::min(order.size(), static_cast<std::size_t>(count)));
  return climb_errors(lower, upper, errors_at, points(Eigen::all, order), errors(order));
}

}  // namespace samara::pgd
