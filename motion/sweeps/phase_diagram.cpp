#include "samara/motion/sweeps/phase_diagram.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/motion/sweeps/pattern_map.h"
#include "samara/motion/sweeps/sweep_plan.h"

namespace samara::motion {

namespace {

/// Falls per pattern of one point.
Eigen::RowVectorXd counts_of_point(const Sweep& sweep, Eigen::Index point) {
  Eigen::RowVectorXd counts = Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(kPatterns));
  for (Eigen::Index r = 0; r < sweep.release_count(); ++r) {
    const auto fall = static_cast<std::size_t>(point * sweep.release_count() + r);
    counts[static_cast<Eigen::Index>(sweep.labels[fall].pattern)] += 1.0;
  }
  return counts;
}

Eigen::Index whole_points(const Sweep& sweep) {
  return sweep.fall_count() / sweep.release_count();
}

/// The body's values of the sweep's coordinates.
Eigen::VectorXd point_of(const Sweep& sweep, const models::ParametricModel& body) {
  const models::ModelInfo& info = body.model().info();
  const std::vector<double> parameters = body.parameters({});
  std::vector<double> initial(info.states.size());
  body.initial({}, initial);
  Eigen::VectorXd point(static_cast<Eigen::Index>(sweep.names.size()));
  for (Eigen::Index k = 0; k < point.size(); ++k) {
    const std::string& name = sweep.names[static_cast<std::size_t>(k)];
    const auto parameter = std::ranges::find(info.parameters, name, &models::ParameterInfo::name);
    const auto state =
        std::ranges::find_if(info.states, [&](const auto& one) { return one.name + "(0)" == name; });
    if (parameter == info.parameters.end() && state == info.states.end())
      throw ArgumentError(fmt::format("the sweep has the coordinate \"{}\", which the model has not", name));
    point[k] = parameter != info.parameters.end()
                   ? parameters[static_cast<std::size_t>(parameter - info.parameters.begin())]
                   : initial[static_cast<std::size_t>(state - info.states.begin())];
  }
  return point;
}

void expect_same(const std::string& name, double given, double swept) {
  const bool both_unknown = std::isnan(given) && std::isnan(swept);
  if (both_unknown || std::abs(given - swept) <= 1e-9 * std::max(std::abs(given), std::abs(swept))) return;
  throw ArgumentError(fmt::format("{} of the body is {:.10g}, expected {:.10g}, at which the sweep held it",
                                  name, given, swept));
}

/// What depends on coordinates, as a mass on a length, is compared at the body's own.
void expect_same_body(const Sweep& sweep, const Eigen::VectorXd& point, const models::ParametricModel& body) {
  const SweepPlan plan = parse_sweep_plan(sweep.plan_text, "the plan of the sweep");
  const models::ParametricModel swept = plan.parametric_model();
  const Eigen::VectorXd lane = plan.lane_points(point.transpose()).row(0);
  const std::span<const double> q(lane.data(), static_cast<std::size_t>(lane.size()));
  const models::ModelInfo& info = body.model().info();
  const std::vector<double> own = body.parameters({}), held = swept.parameters(q);
  for (std::size_t k = 0; k < info.parameters.size(); ++k)
    expect_same(info.parameters[k].name, own[k], held[k]);
  std::vector<double> own_start(info.states.size()), start(info.states.size());
  body.initial({}, own_start);
  swept.initial(q, start);
  for (std::size_t k = 0; k < info.states.size(); ++k) {
    const std::string name = info.states[k].name + "(0)";
    // A release sets it.
    if (std::ranges::find(swept.free(), name, &models::FreeCoordinate::name) != swept.free().end()) continue;
    expect_same(name, own_start[k], start[k]);
  }
}

}  // namespace

Eigen::MatrixXd release_shares(const Sweep& sweep) {
  Eigen::MatrixXd shares(whole_points(sweep), static_cast<Eigen::Index>(kPatterns));
  for (Eigen::Index n = 0; n < shares.rows(); ++n)
    shares.row(n) = counts_of_point(sweep, n) / static_cast<double>(sweep.release_count());
  return shares;
}

SharesAt shares_at(const Sweep& sweep, const Eigen::VectorXd& point) {
  const Eigen::Index count = whole_points(sweep);
  if (count == 0) throw ArgumentError("the sweep has no falls, expected at least those of one point");
  if (point.size() != sweep.lower.size())
    throw ArgumentError(
        fmt::format("the point has {} coordinates, expected {}", point.size(), sweep.lower.size()));
  for (Eigen::Index k = 0; k < point.size(); ++k) {
    const double room = room_beside(sweep.lower[k], sweep.upper[k]);
    if (!(point[k] >= sweep.lower[k] - room && point[k] <= sweep.upper[k] + room))
      throw ArgumentError(fmt::format("{} is {}, expected {} to {}: inside the box of the sweep",
                                      sweep.names[static_cast<std::size_t>(k)], point[k], sweep.lower[k],
                                      sweep.upper[k]));
  }
  const Eigen::RowVectorXd width =
      (sweep.upper - sweep.lower).unaryExpr([](double w) { return w > 0.0 ? w : 1.0; }).transpose();
  const Eigen::VectorXd distance =
      ((sweep.points.topRows(count).rowwise() - point.transpose()).array().rowwise() / width.array())
          .square()
          .rowwise()
          .sum();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  const auto last = order.begin() + std::min<Eigen::Index>(PatternMap::kNeighbours, count);
  std::partial_sort(order.begin(), last, order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return distance[a] < distance[b] || (distance[a] == distance[b] && a < b);
  });
  Eigen::RowVectorXd counts = Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(kPatterns));
  for (auto n = order.begin(); n != last; ++n) counts += counts_of_point(sweep, *n);
  SharesAt at;
  at.falls = static_cast<long>(counts.sum());
  for (std::size_t k = 0; k < kPatterns; ++k)
    at.patterns[k] = counted_share(static_cast<long>(counts[static_cast<Eigen::Index>(k)]), at.falls);
  return at;
}

SharesAt shares_of(const Sweep& sweep, const models::ParametricModel& body) {
  const models::ModelInfo& info = body.model().info();
  if (sweep.model != info.name)
    throw ArgumentError(
        fmt::format("the sweep is of the model \"{}\", expected one of \"{}\"", sweep.model, info.name));
  // Older files do not say it.
  if (!sweep.model_text.empty() && sweep.model_text != model_text(info))
    throw ArgumentError(
        fmt::format("the sweep is of another model \"{}\", whose equations or parameters differ, expected "
                    "one of this model",
                    info.name));
  const Eigen::VectorXd point = point_of(sweep, body);
  SharesAt at = shares_at(sweep, point);
  expect_same_body(sweep, point, body);
  return at;
}

PlacedBodies placed_bodies(const Sweep& sweep, Eigen::Index most) {
  PlacedBodies placed;
  std::vector<Eigen::RowVectorXd> counts;
  try {
    const SweepPlan plan = parse_sweep_plan(sweep.plan_text, "the plan of the sweep");
    const models::ParametricModel model = plan.parametric_model();
    std::map<std::pair<double, double>, std::size_t> seen;
    for (const Eigen::Index n : drawn_numbers(whole_points(sweep), most)) {
      const Eigen::VectorXd q = plan.lane_points(sweep.points.row(n)).row(0);
      const FallNumbers numbers =
          fall_numbers(*plan.model, model.parameters({q.data(), static_cast<std::size_t>(q.size())}));
      const auto [at, is_new] = seen.try_emplace({numbers.Re, numbers.I_disc}, placed.bodies.size());
      if (is_new) {
        placed.bodies.push_back(numbers);
        counts.push_back(counts_of_point(sweep, n));
      } else {
        counts[at->second] += counts_of_point(sweep, n);
      }
    }
  } catch (const Error& error) {
    placed.bodies.clear();
    placed.missing = error.what();
    return placed;
  }
  placed.shares.resize(static_cast<Eigen::Index>(counts.size()), static_cast<Eigen::Index>(kPatterns));
  for (std::size_t k = 0; k < counts.size(); ++k) {
    placed.falls.push_back(static_cast<long>(counts[k].sum()));
    placed.shares.row(static_cast<Eigen::Index>(k)) = counts[k] / counts[k].sum();
  }
  return placed;
}

}  // namespace samara::motion
