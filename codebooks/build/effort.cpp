#include "samara/codebooks/build/effort.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "samara/codebooks/book/sobol_points.h"
#include "samara/models/checks/kinks.h"
#include "samara/models/integrators/integrate.h"
#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/tensors/random.h"

namespace samara::codebooks {

double sweep_size(const std::vector<Piece>& pieces) {
  using Corner = std::pair<std::vector<double>, std::vector<double>>;
  std::map<Corner, std::vector<int>> nodes;  // of every cell
  for (const Piece& piece : pieces) {
    const std::vector<pgd::Axis> axes = piece.outline().axes;
    Corner cell;
    for (std::size_t k = 1; k < axes.size(); ++k) {
      cell.first.push_back(axes[k].lower());
      cell.second.push_back(axes[k].upper());
    }
    std::vector<int>& most = nodes.try_emplace(cell, axes.size() - 1, 0).first->second;
    for (std::size_t k = 1; k < axes.size(); ++k) most[k - 1] = std::max(most[k - 1], axes[k].size());
  }
  double size = 0.0;
  for (const auto& [cell, counts] : nodes)
    size += std::accumulate(counts.begin(), counts.end(), 1.0, std::multiplies<>());
  return size;
}

double evaluations_per_trajectory(const Plan& plan, const models::ParametricModel& model) {
  constexpr int kPoints = 16;
  constexpr double kShare = 0.1;
  models::Integrator integrate(model, {.relative_tolerance = std::clamp(kShare * plan.relative, 1e-13, 1e-3)},
                               false);
  Eigen::MatrixXd points = sobol_points(static_cast<int>(plan.box.size()), kPoints, plan.builder.seed);
  for (std::size_t k = 0; k < plan.box.size(); ++k) {
    auto row = points.row(static_cast<Eigen::Index>(k)).array();
    row = plan.box[k].lower + (plan.box[k].upper - plan.box[k].lower) * row;
  }
  double sum = 0.0;
  int count = 0;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const Eigen::VectorXd q = points.col(j);
    const models::Trajectory trajectory =
        integrate({q.data(), static_cast<std::size_t>(q.size())}, {&plan.end, 1});
    if (!trajectory.is_usable()) continue;
    sum += static_cast<double>(trajectory.rhs_evaluations);
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

namespace {

/// The slabs that cost most for their length, as few as took half of the evaluations of the march.
struct CostlySlabs {
  std::vector<std::size_t> slabs;  ///< the costliest first
  double work = 0.0;               ///< share of the evaluations
  double time = 0.0;               ///< share of the time, over all cells
};

CostlySlabs costliest(const std::vector<pgd::SlabRecord>& history) {
  constexpr double kHalf = 0.5;
  CostlySlabs costly;
  double work = 0.0, time = 0.0;
  for (const pgd::SlabRecord& slab : history) {
    work += static_cast<double>(slab.evaluations);
    time += slab.end - slab.begin;
  }
  std::vector<std::size_t> order(history.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto density = [&](std::size_t k) {
    return static_cast<double>(history[k].evaluations) / (history[k].end - history[k].begin);
  };
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return density(a) > density(b); });
  for (const std::size_t k : order) {
    if (costly.work >= kHalf) break;
    costly.slabs.push_back(k);
    costly.work += static_cast<double>(history[k].evaluations) / work;
    costly.time += (history[k].end - history[k].begin) / time;
  }
  return costly;
}

/// What the law is asked at: some points of the cell, at some times of the slab.
std::vector<models::ModelPoint> points_of(const pgd::TrainField& field,
                                          const models::ParametricModel& model) {
  constexpr int kPoints = 16, kTimes = 3;
  const std::vector<pgd::Axis> parameters(field.axes().begin() + 1, field.axes().end());
  pgd::Random random(1);
  const Eigen::MatrixXd corners = pgd::corner_points(parameters);
  Eigen::MatrixXd places(static_cast<Eigen::Index>(parameters.size()), corners.cols() + kPoints);
  places << corners, pgd::random_points(parameters, kPoints, random);
  const pgd::Axis& time = field.axes().front();
  std::vector<models::ModelPoint> points;
  for (Eigen::Index j = 0; j < places.cols(); ++j) {
    for (int k = 0; k < kTimes; ++k) {
      std::vector<double> at = {time.lower() + time.length() * k / (kTimes - 1)};
      at.insert(at.end(), places.col(j).begin(), places.col(j).end());
      const Eigen::VectorXd x = field(at);
      points.push_back({at.front(), {x.begin(), x.end()}, model.parameter_values(std::span(at).subspan(1))});
    }
  }
  return points;
}

/// The largest kink of the law at zero of a state that changes its sign in the slab.
std::optional<models::Kink> kink_in(const pgd::TrainField& field, const models::ParametricModel& model) {
  const std::vector<models::ModelPoint> points = points_of(field, model);
  const std::vector<models::StateInfo>& infos = model.model().info().states;
  const auto changes_sign = [&](const std::string& name) {
    const auto s =
        static_cast<std::size_t>(std::ranges::find(infos, name, &models::StateInfo::name) - infos.begin());
    const auto of_state = [s](const models::ModelPoint& point) { return point.x[s]; };
    const auto [least, most] = std::ranges::minmax(points, {}, of_state);
    return of_state(least) <= 0.0 && of_state(most) >= 0.0;
  };
  std::optional<models::Kink> largest;
  const auto size = [](const models::Kink& kink) { return std::pair(kink.is_of_rate, kink.jump); };
  for (const models::Kink& kink : models::kinks_at_zero(model.model(), points)) {
    if (changes_sign(kink.state) && (!largest || size(kink) > size(*largest))) largest = kink;
  }
  return largest;
}

}  // namespace

std::string costly_slabs(const pgd::SlabResult& result, const models::ParametricModel& model) {
  constexpr std::size_t kFewest = 8;
  constexpr double kShort = 0.1;
  if (result.history.size() < kFewest) return "";
  const CostlySlabs costly = costliest(result.history);
  if (!(costly.time <= kShort)) return "";
  const pgd::SlabRecord& worst = result.history[costly.slabs.front()];
  std::string text = fmt::format(
      "; {:.0f} % of the evaluations of the march went into {:.2g} % of its time, most for its "
      "length into t = {:.6g} to {:.6g}",
      100.0 * costly.work, 100.0 * costly.time, worst.begin, worst.end);
  if (result.history.size() != result.pieces.size()) return text;
  const pgd::TrainField& field = result.pieces[costly.slabs.front()];
  if (result.cells > 1) {
    std::vector<pgd::Axis> parameters(field.axes().begin() + 1, field.axes().end());
    std::vector<double> centre;
    for (const pgd::Axis& axis : parameters) centre.push_back(0.5 * (axis.lower() + axis.upper()));
    text += fmt::format(", in the cell about {}", pgd::described(parameters, centre));
  }
  if (const std::optional<models::Kink> kink = kink_in(field, model))
    text += fmt::format(", where {}", models::described(*kink));
  return text;
}

}  // namespace samara::codebooks
