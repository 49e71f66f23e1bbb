#include "samara/motion/planning/plan_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/batch/watch_batch.h"
#include "samara/models/laws/registry.h"
#include "samara/motion/database/motion_graph.h"

namespace samara::motion {

namespace {

/// Of a fall's coefficients to the plan's box, in widths of its ranges.
double distance_to_box(const MotionPlan& plan, const MotionRun& run) {
  const std::vector<std::string>& names = plan.database->coefficient_names;
  double square = 0.0;
  for (const SteeredCoefficient& range : plan.box) {
    const auto found = std::ranges::find(names, range.name);
    if (found == names.end()) continue;
    const double value = run.coefficients[found - names.begin()];
    const double outside = std::max({0.0, range.lower - value, value - range.upper});
    square += std::pow(outside / (range.upper - range.lower), 2);
  }
  return std::sqrt(square);
}

void require_pattern_in_box(const MotionPlan& plan, Pattern pattern) {
  const MotionDatabase& database = *plan.database;
  const MotionRun* nearest = nullptr;
  double least = std::numeric_limits<double>::infinity();
  int inside = 0;
  for (const MotionRun& run : database.runs) {
    const double distance = distance_to_box(plan, run);
    inside += distance == 0.0 ? 1 : 0;
    if (run.pattern != pattern || !(distance < least)) continue;
    nearest = &run;
    least = distance;
  }
  if (least == 0.0 || nearest == nullptr) return;
  std::string text;
  for (Eigen::Index k = 0; k < nearest->coefficients.size(); ++k)
    text += fmt::format("{}{} = {:.4g}", k == 0 ? "" : ", ",
                        database.coefficient_names[static_cast<std::size_t>(k)], nearest->coefficients[k]);
  throw ArgumentError(fmt::format("{} is 0 of {} falls of the database within [box]; the nearest has {}",
                                  to_string(pattern), inside, text));
}

bool is_of(const MotionDatabase& database, Eigen::Index n, const AskedSegment& asked) {
  const MotionSegment& segment = database.segments[static_cast<std::size_t>(n)];
  if (asked.kind) return !segment.is_steady && segment.kind == *asked.kind;
  return database.runs[static_cast<std::size_t>(segment.run)].pattern == *asked.pattern;
}

std::string name_of(const AskedSegment& asked) {
  return asked.kind ? to_string(*asked.kind) : to_string(*asked.pattern);
}

/// From the segments of one kind to some of another over one edge; of patterns over any number of them.
bool leads(const MotionDatabase& database, const MotionGraph& graph, const AskedSegment& from,
           const AskedSegment& to) {
  std::vector<char> seen(database.segments.size(), 0);
  std::vector<Eigen::Index> open;
  for (Eigen::Index n = 0; n < database.segment_count(); ++n) {
    if (is_of(database, n, from)) open.push_back(n);
  }
  while (!open.empty()) {
    const auto node = static_cast<std::size_t>(open.back());
    open.pop_back();
    for (Eigen::Index k = graph.first_edge[node]; k < graph.first_edge[node + 1]; ++k) {
      const Eigen::Index next = graph.edges[static_cast<std::size_t>(k)].to;
      if (is_of(database, next, to)) return true;
      if (from.kind || std::exchange(seen[static_cast<std::size_t>(next)], 1) != 0) continue;
      open.push_back(next);
    }
  }
  return false;
}

/// m/s, upward, of all falls between their first and last events.
double fastest_rise(const MotionDatabase& database) {
  std::vector<std::string> free = database.coefficient_names;
  for (const std::string& state : database.state_names) free.push_back(state + "(0)");
  const models::ParametricModel model(models::find_model(database.model), database.fixed, free);
  const auto coefficients = std::ssize(database.coefficient_names);
  Eigen::MatrixXd points(database.segment_count(), std::ssize(free));
  for (Eigen::Index n = 0; n < points.rows(); ++n) {
    const auto run = static_cast<std::size_t>(database.segments[static_cast<std::size_t>(n)].run);
    points.row(n).head(coefficients) = database.runs[run].coefficients.transpose();
    points.row(n).tail(database.starts.cols()) = database.starts.row(n);
  }
  const MovingStates moving = database.moving_states();
  Eigen::VectorXd rises = Eigen::VectorXd::Zero(points.rows());
  models::watch_batch(model, points,
                      [&](Eigen::Index n, double t, std::span<const double> state) {
                        rises[n] = std::max(rises[n], moving.at(state).velocity.z());
                        return t < database.segments[static_cast<std::size_t>(n)].duration;
                      },
                      {.step = database.step,
                       .interval = database.step,
                       .end = std::ranges::max(database.segments, {}, &MotionSegment::duration).duration});
  return rises.maxCoeff();
}

}  // namespace

void require_patterns_in_box(const MotionPlan& plan) {
  if (!plan.database || !plan.sequence || plan.sequence->is_drawn()) return;
  std::optional<Pattern> last;
  for (const AskedSegment& asked : plan.sequence->segments) {
    if (asked.pattern && asked.pattern != last) require_pattern_in_box(plan, *asked.pattern);
    last = asked.pattern;
  }
}

void require_ways(const MotionPlan& plan) {
  if (!plan.database || !plan.sequence || plan.sequence->is_drawn()) return;
  const std::vector<AskedSegment>& asked = plan.sequence->segments;
  std::optional<MotionGraph> graph;
  std::vector<std::pair<AskedSegment, AskedSegment>> known;
  for (std::size_t n = 1; n < asked.size(); ++n) {
    const std::pair two(asked[n - 1], asked[n]);
    const bool goes_on = two.first.pattern && two.first == two.second;
    if (goes_on || std::ranges::find(known, two) != known.end()) continue;
    known.push_back(two);
    if (!graph) graph = motion_graph(*plan.database);
    if (leads(*plan.database, *graph, two.first, two.second)) continue;
    const char* const why = two.first.kind ? "no segment of that kind leads to one in the database"
                                           : "from falls of that pattern no way leads there in the database";
    throw ArgumentError(
        fmt::format("asks for {} after {}: {}", name_of(two.second), name_of(two.first), why));
  }
}

void require_rise(const MotionPlan& plan) {
  if (!plan.sketch || !plan.sketch->is_timed()) return;
  const Eigen::MatrixX3d& points = plan.sketch->points();
  const Eigen::VectorXd& times = plan.sketch->times();
  if (plan.starts_at_rest()) {
    Eigen::Index highest = 0;
    const double top = points.col(2).maxCoeff(&highest), height = plan.release_height();
    if (top > height + 2.0 * plan.semi_length() + 0.02 * height)
      throw ArgumentError(
          fmt::format("is at height {:.6g} at {:.6g}, above the release at {:.6g}: what is let go at rest "
                      "never comes up there",
                      top, times[highest], height));
  }
  Eigen::Index steepest = 1;
  double rise = 0.0;
  for (Eigen::Index k = 1; k < points.rows(); ++k) {
    const double speed = (points(k, 2) - points(k - 1, 2)) / (times[k] - times[k - 1]);
    if (speed <= rise) continue;
    rise = speed;
    steepest = k;
  }
  if (!plan.database || rise == 0.0) return;
  const double most = fastest_rise(*plan.database);
  if (rise > most)
    throw ArgumentError(fmt::format(
        "rises by {:.4g} in unit time from {:.6g} on, expected at most {:.4g}: no fall of the database rises "
        "faster",
        rise, times[steepest - 1], most));
}

}  // namespace samara::motion
