#include "samara/pgd/slab_evolution.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/number_archive.h"
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

/// What a march begins with.
struct NextMarch {
  NextMarch(const SlabOptions& options, Eigen::VectorXd first_scales) : scales(std::move(first_scales)) {
    const double share = kFirstShare * options.tolerance;
    local = {std::max(kCoarse, share), share};
  }

  void tighten(const SlabResult& result, double tolerance) {
    if (result.marches == 1) {
      local.wanted = std::min(local.wanted, local.largest);
      return;
    }
    const double ratio = 0.7 * kSeen * tolerance / result.error;
    const double factor = std::clamp(std::pow(ratio, 1.0 / kOrder), 0.05, 0.5);
    local.wanted *= factor;
    local.largest *= std::max(std::sqrt(factor), 0.5);
  }

  LocalTolerance local;
  Eigen::VectorXd scales;
};

/// Where a second march ends early, a third would end there too.
bool is_last(const SlabMarch& march, const SlabResult& result, const SlabOptions& options) {
  return march.status() == SlabStatus::cancelled || march.status() == SlabStatus::max_evaluations ||
         (march.status() != SlabStatus::converged && result.marches > 1) ||
         result.marches >= options.max_marches;
}

/// The state between two slabs but for that of the march itself; it begins with what it must agree with.
template <class Archive>
void transfer(Archive& archive, const AdaptiveProblem& problem, const SlabOptions& options, NextMarch& plan,
              SlabResult& result) {
  std::vector<double> belongs_to = {static_cast<double>(problem.states.size()),
                                    static_cast<double>(problem.parameters.size()),
                                    problem.end,
                                    options.tolerance,
                                    static_cast<double>(options.time_points),
                                    static_cast<double>(options.max_cells),
                                    static_cast<double>(options.guards)};
  const std::vector<double> expected = belongs_to;
  archive(belongs_to, result.marches, result.evaluations, result.grid_evaluations, plan.local.wanted,
          plan.local.largest, plan.scales);
  if (belongs_to != expected || plan.scales.size() != static_cast<Eigen::Index>(problem.states.size()) ||
      !(plan.scales.minCoeff() > 0.0) || !(plan.local.wanted > 0.0))
    throw ArgumentError("the stored state of a march in slabs belongs to another problem or other options");
}

/// Stores the state from time to time.
class Checkpoint {
 public:
  Checkpoint(const AdaptiveProblem& problem, const SlabOptions& options, NextMarch& plan, SlabResult& result)
      : problem_(problem), options_(options), plan_(plan), result_(result) {}

  void save(SlabMarch& march) {
    const Clock::time_point now = Clock::now();
    if (now - saved_at_ < 20 * took_) return;
    NumberWriter writer;
    transfer(writer, problem_, options_, plan_, result_);
    std::vector<double> state = writer.numbers();
    const std::vector<double> rest = march.state();
    state.insert(state.end(), rest.begin(), rest.end());
    options_.checkpoint(state);
    saved_at_ = Clock::now();
    took_ = saved_at_ - now;
  }

 private:
  const AdaptiveProblem& problem_;
  const SlabOptions& options_;
  NextMarch& plan_;
  SlabResult& result_;
  Clock::time_point saved_at_ = Clock::now();
  Clock::duration took_ = Clock::duration::zero();
};

}  // namespace

SlabResult solve_by_slabs(const AdaptiveProblem& problem, const SlabOptions& options,
                          std::span<const double> state) {
  validate(problem);
  validate(options);
  const Clock::time_point begin = Clock::now();
  const Eigen::VectorXd first = Eigen::Map<const Eigen::VectorXd>(
      problem.scales.data(), static_cast<Eigen::Index>(problem.scales.size()));
  SlabResult result;
  NextMarch plan(options, first);
  std::span<const double> started;
  if (!state.empty()) {
    NumberReader reader(state);
    transfer(reader, problem, options, plan, result);
    started = reader.rest();
  }
  while (true) {
    const long left = options.max_evaluations == 0 ? -1 : options.max_evaluations - result.evaluations;
    SlabMarch march(problem, options, plan.scales, plan.local, left);
    if (!started.empty()) march.restore(std::exchange(started, {}));
    Checkpoint checkpoint(problem, options, plan, result);
    march.run(options.checkpoint ? [&] { checkpoint.save(march); } : std::function<void()>());
    ++result.marches;
    result.evaluations += march.evaluations();
    result.grid_evaluations += march.grid_evaluations();
    const Eigen::VectorXd ranges = plan.scales.cwiseProduct(march.ranges());
    const Eigen::VectorXd next = scales_of(problem, ranges, first);
    // Errors of this march in the ranges it has found.
    result.error = march.carried_error() * plan.scales.cwiseQuotient(next).maxCoeff();
    const bool met = result.error <= kSeen * options.tolerance;
    if (met || is_last(march, result, options)) {
      take(march, met, next, result);
      break;
    }
    plan.tighten(result, options.tolerance);
    plan.scales = next;
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
