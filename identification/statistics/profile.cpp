#include "samara/identification/statistics/profile.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/base/rounded.h"
#include "samara/identification/statistics/quantiles.h"

namespace samara::identification {

namespace {

/// Steps aim at this part of the root of the threshold, in which a quadratic profile is straight.
constexpr double kRootStep = 1.0 / 3.0;
/// The crossing is close enough once the root of the deviance is this near, relatively: what is left to
/// interpolate is a hundredth of a standard error or so.
constexpr double kCloseRoot = 0.03;
constexpr int kMostFailures = 6;
// A deviance below minus this is a better optimum.
constexpr double kBetterMargin = 0.01;

/// The deviance at the ends of the interval.
double deviance_quantile(const ProfileOptions& options) {
  if (std::isinf(options.degrees_of_freedom)) return chi_squared_quantile(1, options.confidence);
  return fisher_quantile(1, options.degrees_of_freedom, options.confidence);
}

struct Node {
  double value = 0.0;
  double cost = 0.0;
  double root = 0.0;  ///< of the deviance, with its sign
  Eigen::VectorXd point = {};
};

/// Walks from the optimum to one side.
class Walk {
 public:
  Walk(const ProfileTarget& target, const ProfileOptions& options, const ProfileSolver& solve, double sign)
      : target_(target),
        options_(options),
        solve_(solve),
        sign_(sign),
        threshold_(std::sqrt(deviance_quantile(options))) {}

  void run(const Eigen::VectorXd& warm_start) {
    nodes_.push_back({target_.best, target_.best_cost, 0.0, warm_start});
    double step = first_step();
    int failures = 0;
    while (solves_ < options_.max_points) {
      const Node& last = nodes_.back();
      const double room = room_from(last.value);
      if (room <= 0.0) {
        end_ = ProfileEnd::box;
        return;
      }
      const double length = std::min(step, room);
      const double value = length == room ? bound() : last.value + sign_ * length;
      const std::optional<Node> next = solved(value, last.point);
      if (!next) {
        step = 0.5 * length;
        end_ = ProfileEnd::failed;
        if (++failures > kMostFailures) return;
        continue;
      }
      end_ = ProfileEnd::flat;
      // After a failure a step just as long comes first, not a longer one that would fail again.
      step = next_step(length, next->root - last.root);
      if (failures > 0) step = std::min(step, length);
      failures = 0;
      nodes_.push_back(*next);
      if (next->root >= threshold_) {
        close_in();
        return;
      }
    }
  }

  const std::vector<Node>& nodes() const { return nodes_; }
  ProfileEnd end() const { return end_; }
  std::optional<double> crossing() const { return crossing_; }
  int solves() const { return solves_; }

 private:
  double bound() const { return sign_ > 0.0 ? target_.upper : target_.lower; }

  double room_from(double value) const {
    const double room = sign_ * (bound() - value);
    const double width = target_.upper - target_.lower;
    return std::isfinite(width) && room < 1e-9 * width ? 0.0 : room;
  }

  double first_step() const {
    if (target_.scale > 0.0 && std::isfinite(target_.scale)) return kRootStep * threshold_ * target_.scale;
    const double width = target_.upper - target_.lower;
    return std::isfinite(width) ? 0.02 * width : std::max(0.1 * std::abs(target_.best), 1e-3);
  }

  double next_step(double length, double rise) const {
    const double wanted = kRootStep * threshold_;
    return length * (rise > 0.5 * wanted ? std::max(wanted / rise, 0.25) : 2.0);
  }

  std::optional<Node> solved(double value, const Eigen::VectorXd& warm_start) {
    ++solves_;
    std::optional<ProfileSolution> solution = solve_(value, warm_start);
    if (!solution || !std::isfinite(solution->cost)) return {};
    const double deviance = 2.0 * (solution->cost - target_.best_cost) / options_.dispersion;
    const double root = std::copysign(std::sqrt(std::abs(deviance)), deviance);
    return Node{value, solution->cost, root, std::move(solution->point)};
  }

  /// Between the last two nodes: by straight lines in the root and by halves, in turns.
  void close_in() {
    end_ = ProfileEnd::crossed;
    Node inner = nodes_[nodes_.size() - 2];
    Node outer = nodes_.back();
    for (bool halve = false; solves_ < options_.max_points; halve = !halve) {
      if (std::min(outer.root - threshold_, threshold_ - inner.root) < kCloseRoot * threshold_) break;
      const double value = halve ? 0.5 * (inner.value + outer.value) : interpolated(inner, outer);
      const std::optional<Node> between = solved(value, inner.point);
      if (!between) break;
      nodes_.push_back(*between);
      (between->root >= threshold_ ? outer : inner) = *between;
    }
    crossing_ = interpolated(inner, outer);
  }

  /// Straight in the root of the deviance: exact for a quadratic profile, and between the two in any case.
  double interpolated(const Node& inner, const Node& outer) const {
    const double part = (threshold_ - inner.root) / (outer.root - inner.root);
    return inner.value + part * (outer.value - inner.value);
  }

  const ProfileTarget& target_;
  const ProfileOptions& options_;
  const ProfileSolver& solve_;
  double sign_;
  double threshold_;  ///< of the root
  std::vector<Node> nodes_;
  ProfileEnd end_ = ProfileEnd::flat;
  std::optional<double> crossing_;
  int solves_ = 0;
};

void check(const ProfileTarget& target, const ProfileOptions& options) {
  if (!std::isfinite(target.best) || !std::isfinite(target.best_cost)) {
    throw ArgumentError(
        fmt::format("the profile of \"{}\" begins at {} with cost {}; finite numbers were expected",
                    target.name, target.best, target.best_cost));
  }
  if (!(target.lower <= target.best && target.best <= target.upper)) {
    throw ArgumentError(fmt::format("the profile of \"{}\" begins at {}, outside its box, {} to {}",
                                    target.name, target.best, target.lower, target.upper));
  }
  require(options.confidence > 0.0 && options.confidence < 1.0, "confidence", options.confidence,
          "a number between 0 and 1");
  require_positive(options.dispersion, "dispersion");
  require(options.degrees_of_freedom > 0.0, "degrees_of_freedom", options.degrees_of_freedom,
          "a positive number");
  require(options.max_points >= 1, "max_points", options.max_points, "at least 1");
}

/// The nodes of both sides by ascending value, the optimum once.
void collect(const Walk& below, const Walk& above, Profile& result) {
  std::vector<Node> nodes(below.nodes());
  nodes.insert(nodes.end(), above.nodes().begin() + 1, above.nodes().end());
  std::ranges::sort(nodes, {}, &Node::value);
  for (const Node& node : nodes) {
    result.values.push_back(node.value);
    result.costs.push_back(node.cost);
  }
}

ProfileShape shape_of(const Profile& profile) {
  if (profile.better_value) return ProfileShape::better_elsewhere;
  if (profile.interval_lower && profile.interval_upper) return ProfileShape::identified;
  if (profile.interval_lower) return ProfileShape::lower_limit;
  return profile.interval_upper ? ProfileShape::upper_limit : ProfileShape::flat;
}

/// What ended the steps was neither the threshold nor the box.
bool is_unexplored(ProfileEnd end) {
  return end == ProfileEnd::flat || end == ProfileEnd::failed;
}

}  // namespace

std::string to_string(ProfileShape shape) {
  switch (shape) {
    case ProfileShape::identified:
      return "identified";
    case ProfileShape::lower_limit:
      return "lower limit only";
    case ProfileShape::upper_limit:
      return "upper limit only";
    case ProfileShape::flat:
      return "flat";
    case ProfileShape::better_elsewhere:
      return "better elsewhere";
  }
  throw ArgumentError("a profile of no known shape");
}

std::string to_string(ProfileEnd end) {
  switch (end) {
    case ProfileEnd::crossed:
      return "crossed";
    case ProfileEnd::box:
      return "box";
    case ProfileEnd::flat:
      return "flat";
    case ProfileEnd::failed:
      return "failed";
  }
  throw ArgumentError("a profile with no known end");
}

Profile profile(const ProfileTarget& target, const Eigen::VectorXd& warm_start, const ProfileSolver& solve,
                const ProfileOptions& options) {
  check(target, options);
  Walk below(target, options, solve, -1.0);
  Walk above(target, options, solve, 1.0);
  below.run(warm_start);
  above.run(warm_start);

  Profile result{.name = target.name,
                 .best = target.best,
                 .best_cost = target.best_cost,
                 .confidence = options.confidence,
                 .dispersion = options.dispersion,
                 .degrees_of_freedom = options.degrees_of_freedom,
                 .lower_end = below.end(),
                 .upper_end = above.end(),
                 .solves = below.solves() + above.solves()};
  result.threshold = target.best_cost + 0.5 * options.dispersion * deviance_quantile(options);
  collect(below, above, result);
  const auto least = static_cast<std::size_t>(std::ranges::min_element(result.costs) - result.costs.begin());
  if (result.deviance(result.costs[least]) < -kBetterMargin) {
    result.better_value = result.values[least];
    result.better_cost = result.costs[least];
  } else {
    result.interval_lower = below.crossing();
    result.interval_upper = above.crossing();
  }
  result.shape = shape_of(result);
  return result;
}

namespace {

/// A normal distribution would have its interval twice as far to both sides.
double standard_error_of(const Profile& p) {
  return 0.25 * (*p.interval_upper - *p.interval_lower);
}

}  // namespace

std::string describe(const Profile& p) {
  const std::string sure = fmt::format("({:.3g} %)", 100.0 * p.confidence);
  const bool open_below = is_unexplored(p.lower_end);
  const bool open_above = is_unexplored(p.upper_end);
  switch (p.shape) {
    case ProfileShape::identified:
      return fmt::format("{} to {} {}", rounded(*p.interval_lower, standard_error_of(p)),
                         rounded(*p.interval_upper, standard_error_of(p)), sure);
    case ProfileShape::lower_limit:
      return fmt::format("at least {:.3g} {}{}", *p.interval_lower, sure,
                         open_above ? fmt::format(", not explored beyond {:.5g}", p.values.back()) : "");
    case ProfileShape::upper_limit:
      return fmt::format("at most {:.3g} {}{}", *p.interval_upper, sure,
                         open_below ? fmt::format(", not explored below {:.5g}", p.values.front()) : "");
    case ProfileShape::flat:
      return fmt::format("not determined: anything from {:.5g} to {:.5g} fits {}{}", p.values.front(),
                         p.values.back(), sure, open_below || open_above ? ", not explored beyond" : "");
    case ProfileShape::better_elsewhere:
      return fmt::format("better optimum at {:.5g}: cost {:.6g} instead of {:.6g}", *p.better_value,
                         *p.better_cost, p.best_cost);
  }
  throw ArgumentError("a profile of no known shape");
}

}  // namespace samara::identification
