#include "samara/pgd/evolution/slab_evolution.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/evolution/cross_collocation.h"
#include "samara/pgd/evolution/guard_survey.h"
#include "samara/pgd/evolution/slab_march.h"
#include "samara/pgd/fields/error_scale.h"
#include "samara/pgd/tensors/number_archive.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

using Clock = std::chrono::steady_clock;

/// Of the wanted error, what a slab may add at most: errors of many slabs accumulate and grow.
constexpr double kFirstShare = 0.2;
/// Guard points are few; what they see is held this far below the wanted error.
constexpr double kSeen = 0.5;
/// Of the wanted error, what a march aims at.
constexpr double kAimed = 0.7 * kSeen;
/// A survey expects larger errors than come true, by this factor or so: slabs that are solved err by less than they
/// may.
constexpr double kPessimism = 6.0;
/// Of the wanted error, what must be expected for smaller tolerances from the first slab on: they cost more.
constexpr double kClearly = 0.6;
/// The error falls about like this power of the local tolerance.
constexpr double kOrder = 0.85;

void validate(const SlabOptions& o) {
  constexpr const char* kWhere = "SlabOptions";
  require(o.tolerance > 0.0, "tolerance", o.tolerance, "a positive number", kWhere);
  require(o.max_elements >= 1, "max_elements", o.max_elements, "1 or more", kWhere);
  require(o.joint_slab >= 0.0 && o.joint_slab <= 1.0, "joint_slab", o.joint_slab, "0 to 1", kWhere);
  require(o.first_nodes >= 2, "first_nodes", o.first_nodes, "2 or more", kWhere);
  require(o.max_nodes >= o.first_nodes, "max_nodes", o.max_nodes,
          fmt::format("first_nodes ({}) or more", o.first_nodes), kWhere);
  require(o.max_rank >= 1, "max_rank", o.max_rank, "1 or more", kWhere);
  require(o.max_cells >= 1, "max_cells", o.max_cells, "1 or more", kWhere);
  require(o.guards >= 1, "guards", o.guards, "1 or more", kWhere);
  require(o.max_marches >= 1, "max_marches", o.max_marches, "1 or more", kWhere);
  require(o.max_evaluations >= 0, "max_evaluations", o.max_evaluations, "0 or more", kWhere);
}

void validate(const AdaptiveProblem& problem) {
  check_problem(problem);
  if (!(problem.end > 0.0) || !std::isfinite(problem.end) || problem.parameters.empty() ||
      problem.time.transform != Transform::none) {
    throw ArgumentError(fmt::format(
        "a problem to the time {}, transform \"{}\", with {} parameters; expected a positive time "
        "without a transform and at least one parameter",
        problem.end, to_string(problem.time.transform), problem.parameters.size()));
  }
}

/// What errors of the states are divided by, where they have these ranges.
Eigen::VectorXd scales_of(const AdaptiveProblem& problem, const Eigen::VectorXd& ranges) {
  const Eigen::VectorXd starts = start_sizes(problem);
  Eigen::VectorXd scales(ranges.size());
  for (Eigen::Index s = 0; s < scales.size(); ++s) {
    const auto state = static_cast<std::size_t>(s);
    scales[s] = error_scale({.range = ranges[s],
                             .floor = problem.scale_floors[state],
                             .size = std::max(problem.scales[state], starts[s])});
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

/// What a march has found.
void take(const SlabMarch& march, SlabResult& result) {
  for (const MarchPiece& piece : march.pieces()) {
    if (piece.end <= march.reached()) {
      result.pieces.push_back(piece.field);
    } else if (piece.field.axes()[0].lower() < march.reached()) {
      result.pieces.push_back(shortened(piece.field, march.reached()));
    }
  }
  result.history = march.history();
  result.cells = march.cells();
  result.reached = march.reached();
}

/// A march that has reached the end: enough to have it again.
struct CompleteMarch {
  std::vector<double> state;
  Eigen::VectorXd scales;  ///< what it measured in
  Eigen::VectorXd ranges;  ///< what it found
  double error = std::numeric_limits<double>::infinity();
};

template <class Archive>
void transfer(Archive& archive, CompleteMarch& march) {
  archive(march.state, march.scales, march.ranges, march.error);
}

/// What a stored state must agree with.
std::vector<double> numbers_of(const AdaptiveProblem& problem, const SlabOptions& options) {
  NumberWriter writer;
  const auto add = [&](auto... numbers) { writer(numbers...); };
  add(problem.states.size(), problem.parameters.size(), problem.end);
  for (const AdaptiveAxis& axis : problem.parameters) {
    add(axis.lower, axis.upper, static_cast<int>(axis.basis), static_cast<int>(axis.label.transform),
        axis.nodes.value_or(0));
  }
  for (std::size_t s = 0; s < problem.states.size(); ++s)
    add(problem.scales[s], problem.scale_floors[s], problem.initial[s].value, problem.initial[s].axis);
  add(options.tolerance, options.max_elements, options.joint_slab, options.first_nodes, options.max_nodes,
      options.max_rank, options.max_cells, options.guards, options.max_marches, options.max_evaluations,
      static_cast<std::uint32_t>(options.seed >> 32), static_cast<std::uint32_t>(options.seed));
  return writer.numbers();
}

/// March after march, each in the ranges that the one before has found, until one meets the tolerance. The guard
/// points alone give the first ranges, and how errors grow.
class Marches {
 public:
  Marches(const AdaptiveProblem& problem, const SlabOptions& options, SlabSolver& solver)
      : problem_(problem),
        options_(options),
        solver_(solver),
        first_scales_(Eigen::Map<const Eigen::VectorXd>(problem.scales.data(),
                                                        static_cast<Eigen::Index>(problem.scales.size()))),
        loosest_{kFirstShare * options.tolerance, kFirstShare * options.tolerance},
        local_(loosest_),
        scales_(first_scales_) {}

  SlabResult run(std::span<const double> state) {
    const Clock::time_point begin = Clock::now();
    bool goes_on = !state.empty() || prepare();
    while (goes_on) {
      std::span<const double> started;
      if (!state.empty()) started = restore(std::exchange(state, {}));
      SlabMarch march(problem_, options_, solver_, scales_, local_, result_.evaluations);
      if (!started.empty()) march.restore(started);
      saved_at_ = Clock::now();
      march.run(options_.checkpoint ? [&] { save(march); } : std::function<void()>());
      goes_on = !ends_with(march);
    }
    result_.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    return std::move(result_);
  }

 private:
  /// @returns whether there is to be a march
  bool prepare() {
    const GuardSurvey survey = survey_guards(problem_, options_, solver_, scales_, local_.wanted);
    result_.evaluations += survey.evaluations;
    scales_ = scales_of(problem_, scales_.cwiseProduct(survey.ranges));
    const double expected = survey.growth / kPessimism * local_.wanted;
    if (expected > kClearly * options_.tolerance)
      lower(std::clamp(kAimed * options_.tolerance / expected, 0.05, 1.0));
    if (survey.cancelled) {
      result_.status = Termination::cancelled;
      result_.message = "cancelled before the first slab";
    }
    return !survey.cancelled;
  }

  /// Whether this march was the last; then the result is complete.
  bool ends_with(SlabMarch& march) {
    ++result_.marches;
    result_.evaluations += march.evaluations();
    result_.grid_evaluations += march.grid_evaluations();
    const Eigen::VectorXd ranges = scales_of(problem_, scales_.cwiseProduct(march.ranges()));
    // Errors of this march in the ranges it has found.
    const double error = march.carried_error() * scales_.cwiseQuotient(ranges).maxCoeff();
    const bool complete = march.status() == Termination::converged;
    const bool met = complete && error <= kSeen * options_.tolerance;
    // The first is kept whatever it errs by: the error is infinite where a guard point's own equations were not solved.
    if (complete && (best_.state.empty() || !(error >= best_.error)))
      best_ = {march.state(), scales_, ranges, error};
    const bool is_too_strict = march.status() == Termination::not_resolved && local_.wanted < loosest_.wanted;
    if (!met && (is_too_strict || !is_last(march))) {
      if (is_too_strict) {
        loosen();
      } else {
        loosest_ = local_;
        tighten(error);
        scales_ = ranges;
      }
      return false;
    }
    const bool cut = !complete && march.status() != Termination::cancelled;
    if (!best_.state.empty() && (complete || cut)) {
      take_best(cut ? march.ending()->message : std::string());
    } else {
      take_last(march, ranges, error);
    }
    return true;
  }

  /// Where a march ends early, or leaves slabs as they are, another would do so too.
  bool is_last(const SlabMarch& march) const {
    return march.status() != Termination::converged || march.left() > 0 ||
           result_.marches >= options_.max_marches;
  }

  /// Once: what is not resolved at small tolerances, of kinks above all, may be at larger ones.
  void loosen() {
    const bool is_first = best_.state.empty();
    local_ = is_first ? loosest_
                      : LocalTolerance{std::sqrt(local_.wanted * loosest_.wanted),
                                       std::sqrt(local_.largest * loosest_.largest)};
    loosest_ = {};
  }

  void tighten(double error) {
    const double ratio = kAimed * options_.tolerance / error;
    lower(std::clamp(std::pow(ratio, 1.0 / kOrder), 0.05, 0.5));
  }

  void lower(double factor) {
    local_.wanted *= factor;
    local_.largest *= std::max(std::sqrt(factor), 0.5);
  }

  /// @param cut_by why the last march, at smaller tolerances, has ended early; empty: it has not
  void take_best(const std::string& cut_by) {
    SlabMarch march(problem_, options_, solver_, best_.scales, local_, 0);
    march.restore(best_.state);
    march.run();
    take(march, result_);
    result_.error = best_.error;
    result_.ranges.assign(best_.ranges.begin(), best_.ranges.end());
    result_.status = best_.error <= kSeen * options_.tolerance ? Termination::converged : Termination::missed;
    result_.message = fmt::format("error {:.3g} of the range at the guard points after {} march{}",
                                  best_.error, result_.marches, result_.marches == 1 ? "" : "es");
    if (march.left() > 0) {
      result_.message += fmt::format("; {} of {} slabs are left as they are: {}", march.left(),
                                     march.history().size(), reason_for_slabs_left());
    }
    if (!cut_by.empty()) result_.message += fmt::format("; the last, at smaller tolerances: {}", cut_by);
  }

  std::string reason_for_slabs_left() const {
    if (!solver_.is_exact()) return fmt::format("{} comes no closer", solver_.name());
    return "the nodes that are prescribed do not suffice";
  }

  void take_last(const SlabMarch& march, const Eigen::VectorXd& ranges, double error) {
    take(march, result_);
    result_.error = error;
    result_.ranges.assign(ranges.begin(), ranges.end());
    result_.where = march.ending()->where;
    result_.status = march.ending()->status;
    result_.message = march.ending()->message;
  }

  /// Stores the state from time to time.
  void save(SlabMarch& march) {
    const Clock::time_point now = Clock::now();
    if (now - saved_at_ < 20 * took_) return;
    NumberWriter writer;
    transfer_marches(writer);
    std::vector<double> state = writer.numbers();
    const std::vector<double> rest = march.state();
    state.insert(state.end(), rest.begin(), rest.end());
    options_.checkpoint(state);
    saved_at_ = Clock::now();
    took_ = saved_at_ - now;
  }

  /// @returns the state of the march that was under way
  std::span<const double> restore(std::span<const double> state) {
    NumberReader reader(state);
    transfer_marches(reader);
    if (reader.rest().empty()) throw ArgumentError("the stored state of a march in slabs has no march");
    return reader.rest();
  }

  /// All but the march under way.
  template <class Archive>
  void transfer_marches(Archive& archive) {
    const std::vector<double> expected = numbers_of(problem_, options_);
    std::vector<double> belongs_to = expected;
    archive(belongs_to);
    if (belongs_to != expected)
      throw ArgumentError("the stored state of a march in slabs belongs to another problem or other options");
    archive(result_.marches, result_.evaluations, result_.grid_evaluations, local_.wanted, local_.largest,
            loosest_.wanted, loosest_.largest, scales_);
    transfer(archive, best_);
    if (scales_.size() != first_scales_.size() || !(scales_.minCoeff() > 0.0) || !(local_.wanted > 0.0) ||
        result_.marches < 0 || result_.evaluations < 0)
      throw ArgumentError("the stored state of a march in slabs has impossible scales, tolerances or counts");
  }

  const AdaptiveProblem& problem_;
  const SlabOptions& options_;
  SlabSolver& solver_;
  const Eigen::VectorXd first_scales_;
  LocalTolerance loosest_;  ///< the largest that a march may go back to; none: 0
  LocalTolerance local_;    ///< of the march under way, as are the scales
  Eigen::VectorXd scales_;
  CompleteMarch best_;
  SlabResult result_;
  Clock::time_point saved_at_ = Clock::now();
  Clock::duration took_ = Clock::duration::zero();
};

}  // namespace

void check_march(const AdaptiveProblem& problem, const SlabOptions& options) {
  validate(problem);
  validate(options);
}

SlabResult solve_by_slabs(const AdaptiveProblem& problem, const SlabOptions& options,
                          std::span<const double> state) {
  CrossCollocation solver(options.max_elements);
  return solve_by_slabs(problem, solver, options, state);
}

SlabResult solve_by_slabs(const AdaptiveProblem& problem, SlabSolver& solver, const SlabOptions& options,
                          std::span<const double> state) {
  check_march(problem, options);
  SlabOptions of_solver = options;
  of_solver.max_elements = std::min(options.max_elements, solver.max_elements());
  return Marches(problem, of_solver, solver).run(state);
}

}  // namespace samara::pgd
