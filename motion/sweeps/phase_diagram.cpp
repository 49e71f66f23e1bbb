#include "samara/motion/sweeps/phase_diagram.h"

#include <algorithm>
#include <map>
#include <numeric>
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
    const double room = 1e-9 * (sweep.upper[k] - sweep.lower[k]);
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

PlacedBodies placed_bodies(const Sweep& sweep, Eigen::Index most) {
  PlacedBodies placed;
  std::vector<Eigen::RowVectorXd> counts;
  try {
    const SweepPlan plan = parse_sweep_plan(sweep.plan_text, "the plan of the sweep");
    const models::ParametricModel model = plan.parametric_model();
    const Eigen::Index count = whole_points(sweep);
    const Eigen::Index stride =
        std::max<Eigen::Index>(1, (count + most - 1) / std::max<Eigen::Index>(1, most));
    std::map<std::pair<double, double>, std::size_t> seen;
    for (Eigen::Index n = 0; n < count; n += stride) {
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
