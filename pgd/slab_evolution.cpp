#include "samara/pgd/slab_evolution.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/slab_march.h"
#include "samara/pgd/train_points.h"

namespace samara::pgd {

namespace {

using Clock = std::chrono::steady_clock;

/// Tolerance of the first march, which finds the ranges of the states.
constexpr double kCoarse = 0.03;
/// Of the wanted error, what a slab may add: errors of many slabs accumulate and grow.
constexpr double kFirstShare = 0.2;
/// Guard points are few; what they see is held this far below the wanted error.
constexpr double kSeen = 0.5;
/// The error falls about like this power of the local tolerance.
constexpr double kOrder = 0.85;

void validate(const SlabOptions& options) {
  if (!(options.tolerance > 0.0) || options.time_points < 2 || options.max_elements < 1 ||
      !(options.largest_slab > 0.0) || !(options.largest_slab <= 1.0) || !(options.least_slab > 0.0) ||
      !(options.least_slab < options.largest_slab) || options.first_nodes < 2 ||
      options.max_nodes < options.first_nodes || options.max_rank < 1 || options.max_cells < 1 ||
      options.guards < 1 || options.max_marches < 1) {
    throw ArgumentError(fmt::format(
        "SlabOptions: tolerance {}, time_points {}, max_elements {}, largest_slab {}, least_slab {}, "
        "first_nodes {}, "
        "max_nodes "
        "{}, max_rank {}, max_cells {}, guards {}, max_marches {}; expected a positive tolerance, slabs "
        "within "
        "(0, 1], at least 2 time points and nodes, and positive numbers",
        options.tolerance, options.time_points, options.max_elements, options.largest_slab,
        options.least_slab, options.first_nodes, options.max_nodes, options.max_rank, options.max_cells,
        options.guards, options.max_marches));
  }
}

void validate(const AdaptiveProblem& problem) {
  check_problem(problem);
  if (problem.system == nullptr || !(problem.end > 0.0) || problem.parameters.empty()) {
    throw ArgumentError(
        fmt::format("a problem {} a system, to the time {} with {} parameters; expected a "
                    "system, a positive time and at least one parameter",
                    problem.system == nullptr ? "without" : "with", problem.end, problem.parameters.size()));
  }
}

/// Ranges of the states, at least their floors; of a state that does not move, its size or one.
Eigen::VectorXd scales_of(const AdaptiveProblem& problem, const Eigen::VectorXd& ranges,
                          const Eigen::VectorXd& fallback) {
  Eigen::VectorXd scales = ranges;
  for (Eigen::Index s = 0; s < scales.size(); ++s) {
    scales[s] = std::max(scales[s], problem.scale_floors[static_cast<std::size_t>(s)]);
    if (!(scales[s] > 1e-12 * fallback[s])) scales[s] = fallback[s];
  }
  return scales;
}

/// The field up to an earlier end.
TrainField shortened(const TrainField& field, double end) {
  std::vector<Axis> axes = field.axes();
  const Axis& time = axes[0];
  std::vector<double> borders(time.borders().begin(), time.borders().end());
  while (borders[borders.size() - 2] >= end) borders.pop_back();
  borders.back() = end;
  axes[0] = Axis::radau(
      {time.name(), time.unit(), time.role()},
      Eigen::Map<const Eigen::VectorXd>(borders.data(), static_cast<Eigen::Index>(borders.size())),
      time.degree());
  TensorTrain train = carried_over(field.train(), field.axes(), axes);
  return {std::move(axes), field.outputs(), std::move(train)};
}

/// The outcome of the last march.
void take(const SlabMarch& march, bool met, const Eigen::VectorXd& ranges, SlabResult& result) {
  for (const SlabMarch::Piece& piece : march.pieces()) {
    if (piece.end <= march.reached()) {
      result.pieces.push_back(piece.field);
    } else if (piece.field.axes()[0].lower() < march.reached()) {
      result.pieces.push_back(shortened(piece.field, march.reached()));
    }
  }
  result.history = march.history();
  result.cells = march.cells();
  result.reached = march.reached();
  result.where = march.where();
  result.ranges.assign(ranges.begin(), ranges.end());
  result.status = march.status();
  result.message = march.message();
  if (march.status() != SlabStatus::converged) return;
  result.status = met ? SlabStatus::converged : SlabStatus::missed;
  result.message = fmt::format("error {:.3g} of the range at the guard points after {} marches", result.error,
                               result.marches);
}

}  // namespace

SlabResult solve_by_slabs(const AdaptiveProblem& problem, const SlabOptions& options) {
  validate(problem);
  validate(options);
  const Clock::time_point begin = Clock::now();
  const Eigen::VectorXd first = Eigen::Map<const Eigen::VectorXd>(
      problem.scales.data(), static_cast<Eigen::Index>(problem.scales.size()));
  Eigen::VectorXd scales = first;
  const double share = kFirstShare * options.tolerance;
  LocalTolerance local = {std::max(kCoarse, share), share};
  SlabResult result;
  while (true) {
    const long left = options.max_evaluations == 0 ? -1 : options.max_evaluations - result.evaluations;
    SlabMarch march(problem, options, scales, local, left);
    march.run();
    ++result.marches;
    result.evaluations += march.evaluations();
    result.grid_evaluations += march.grid_evaluations();
    const Eigen::VectorXd ranges = scales.cwiseProduct(march.ranges());
    const Eigen::VectorXd next = scales_of(problem, ranges, first);
    // Errors of this march in the ranges it has found.
    result.error = march.carried_error() * scales.cwiseQuotient(next).maxCoeff();
    const bool met = result.error <= kSeen * options.tolerance;
    // Where the second march ends early, a third would end there too.
    const bool stopped = march.status() == SlabStatus::cancelled ||
                         march.status() == SlabStatus::max_evaluations ||
                         (march.status() != SlabStatus::converged && result.marches > 1);
    if (met || stopped || result.marches >= options.max_marches) {
      take(march, met, next, result);
      break;
    }
    if (result.marches == 1) {
      local.wanted = std::min(local.wanted, local.largest);
    } else {
      const double ratio = 0.7 * kSeen * options.tolerance / result.error;
      const double factor = std::clamp(std::pow(ratio, 1.0 / kOrder), 0.05, 0.5);
      local.wanted *= factor;
      local.largest *= std::max(std::sqrt(factor), 0.5);
    }
    scales = next;
  }
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

std::string to_string(SlabStatus status) {
  static constexpr std::array names = {"converged",    "missed",          "ceases",   "no_contraction",
                                       "not_resolved", "max_evaluations", "cancelled"};
  return names[static_cast<std::size_t>(status)];
}

}  // namespace samara::pgd
