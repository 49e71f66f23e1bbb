#include "samara/pgd/nonlinear/strategy_march.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <initializer_list>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/evolution/slab_train.h"
#include "samara/pgd/nonlinear/linear_slab.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

using Clock = std::chrono::steady_clock;

/// Last correction, or what is left after it, over the tolerance: both are root mean squares.
constexpr double kCorrectionShare = 0.3;
/// Corrections of so many scales belong to no solution.
constexpr double kLargest = 1e4;
constexpr int kDefectPoints = 32;
constexpr int kDefectNodes = 128;

TrainField field(const StrategySlab& slab, const TensorTrain& solution) {
  const EvolutionProblem& problem = slab.problem();
  const Axis time = Axis::radau({problem.time.name(), problem.time.unit(), AxisRole::time}, slab.begin(),
                                slab.begin() + slab.length(), 1, slab.points());
  return slab_field(time, problem.parameters, problem.states, slab.scales(), solution);
}

TensorTrain end_of(const StrategySlab& slab, const TensorTrain& solution) {
  return slab.compressed(last_rows(solution, slab.states()), 0.1 * slab.tolerance());
}

/// Largest |x0 + S f(X) - X|. @param q where @param x the iterate there
double defect_at(const StrategySlab& slab, const Eigen::MatrixXd& q, const Eigen::MatrixXd& x) {
  const Eigen::MatrixXd f = slab.rates(x.bottomRows(slab.rows()), q);
  double largest = 0.0;
  for (Eigen::Index j = 0; j < q.cols(); ++j) {
    Eigen::MatrixXd rest = f.col(j).reshaped(slab.states(), slab.points()) * slab.integration().transpose();
    rest.colwise() += x.col(j).head(slab.states());
    largest = std::max(largest, (rest.reshaped() - x.col(j).tail(slab.rows())).cwiseAbs().maxCoeff());
  }
  return largest;
}

/// At random points of the box: what too few nodes leave is in it.
double defect_off_grid(const StrategySlab& slab, const TensorTrain& solution) {
  const std::vector<Axis>& axes = slab.problem().parameters;
  const Eigen::MatrixXd q = random_points(axes, kDefectPoints, slab.random());
  return defect_at(slab, q, values_at(solution, axes, q));
}

/// At random nodes: what the iteration and crosses leave.
double defect_on_grid(const StrategySlab& slab, const TensorTrain& solution) {
  const IndexBatch entries = slab.random_entries(kDefectNodes);
  return defect_at(slab, slab.parameters_at(entries), values_at(solution, entries));
}

/// The iteration on one slab.
class SlabIteration {
 public:
  /// @param evaluations before this slab @param counts of this slab, as they come
  SlabIteration(const StrategySlab& slab, const StrategyMarchOptions& options, long evaluations,
                const StrategyCounts& counts, StrategyRecord& record)
      : slab_(slab),
        options_(options),
        evaluations_(evaluations),
        counts_(counts),
        record_(record),
        iterate_(slab.constant()) {}

  const TensorTrain& iterate() const { return iterate_; }
  /// A few iterations of another strategy, whether they converge or not; one that fails leaves the start.
  void first_iterate(Strategy& strategy) {
    bool fails = strategy.begin(slab_).has_value();
    for (int k = 0; k < options_.first_iterations && !fails; ++k) fails = !step(strategy);
    if (fails) iterate_ = slab_.constant();
    record_.corrections.clear();
    record_.source_ranks.clear();
    record_.jacobian_ranks.clear();
  }

  /// @returns what ended the iteration before it has converged, or nothing
  std::optional<Ending> run(Strategy& strategy) {
    if (std::optional<Ending> failure = strategy.begin(slab_)) return failure;
    const int most = std::min(options_.max_iterations, strategy.max_iterations());
    double correction = 0.0;
    while (record_.iterations < most) {
      if (options_.progress && !options_.progress({fmt::format("slab {}", slab_.number() + 1), fraction()}))
        return ended(Termination::cancelled, "cancelled");
      if (options_.max_evaluations > 0 &&
          evaluations_ + counts_.rhs + counts_.jacobian >= options_.max_evaluations) {
        return ended(Termination::max_calls,
                     fmt::format("the {} evaluations of f and its Jacobian allowed are used up",
                                 options_.max_evaluations));
      }
      const Outcome<double> corrected = step(strategy);
      if (!corrected) return corrected.ending();
      correction = *corrected;
      ++record_.iterations;
      if (converged(correction)) return std::nullopt;
      if (diverges(strategy, correction)) {
        return ended(Termination::diverged,
                     fmt::format("{} after {} iterations, the last correction is {:.3g} of the scales",
                                 strategy.on_divergence(ratio_), record_.iterations, correction));
      }
    }
    return ended(Termination::max_iterations,
                 fmt::format("{} iterations leave a correction of {:.3g} of the scales", record_.iterations,
                             correction));
  }

 private:
  /// @returns the correction
  Outcome<double> step(Strategy& strategy) {
    const std::optional<double> last =
        record_.corrections.empty() ? std::nullopt : std::optional(record_.corrections.back());
    const Outcome<LinearSlab> linear = strategy.linearise(slab_, iterate_, last);
    if (!linear) return linear.ending();
    raise(record_.source_ranks, linear->source.ranks());
    if (linear->jacobian) raise(record_.jacobian_ranks, linear->jacobian->ranks());
    Outcome<TensorTrain> next = solve(slab_, *linear, pivots_);
    if (!next) return next.ending();
    const double correction = distance(*next, iterate_) / std::sqrt(full_size(*next));
    iterate_ = std::move(*next);
    record_.corrections.push_back(correction);
    return correction;
  }

  bool converged(double correction) {
    const std::vector<double>& all = record_.corrections;
    const double enough = kCorrectionShare * slab_.tolerance();
    ratio_ = all.size() > 1 ? correction / all[all.size() - 2] : 0.0;
    if (correction <= enough) return true;
    record_.contraction = std::max(record_.contraction, ratio_);
    // What is left of a contracting iteration is about ratio / (1 - ratio) of its last correction; but where
    // a separated Jacobian is wrong in a corner of the box, it is more there. The equations tell.
    return all.size() > 1 && ratio_ < 0.5 && correction * ratio_ <= 0.5 * enough &&
           defect_on_grid(slab_, iterate_) <= slab_.tolerance();
  }

  bool diverges(const Strategy& strategy, double correction) {
    growths_ = ratio_ > 1.0 ? growths_ + 1 : 0;
    return !(correction < kLargest) || growths_ >= strategy.patience();
  }

  Ending ended(Termination status, const std::string& why) const {
    return {status, fmt::format("between t = {:.6g} and {:.6g}: {}", slab_.begin(),
                                slab_.begin() + slab_.length(), why)};
  }

  double fraction() const {
    const Axis& time = slab_.problem().time;
    return (slab_.begin() - time.lower()) / time.length();
  }

  static void raise(std::vector<int>& largest, const std::vector<int>& ranks) {
    largest.resize(ranks.size(), 0);
    for (std::size_t k = 0; k < ranks.size(); ++k) largest[k] = std::max(largest[k], ranks[k]);
  }

  const StrategySlab& slab_;
  const StrategyMarchOptions& options_;
  const long evaluations_;  ///< before this slab
  const StrategyCounts& counts_;
  StrategyRecord& record_;
  TensorTrain iterate_;
  CrossPivots pivots_;
  double ratio_ = 0.0;
  int growths_ = 0;
};

void validate(const EvolutionProblem& problem, const StrategyMarchOptions& options) {
  problem.validate();
  if (problem.time.basis() != Basis::radau || problem.parameters.empty()) {
    throw ArgumentError(
        fmt::format("a problem with {} parameter axes and a time axis of the kind {}; expected at least one "
                    "parameter and radau, whose elements are the slabs",
                    problem.parameters.size(), to_string(problem.time.basis())));
  }
  if (options.tolerance > 0.0 && options.max_iterations > 0 && options.max_rank > 0 &&
      options.first_iterations > 0 && options.max_evaluations >= 0)
    return;
  throw ArgumentError(
      fmt::format("StrategyMarchOptions: tolerance {}, max_iterations {}, max_rank {}, "
                  "first_iterations {}, max_evaluations {}; expected positive numbers, the last may be 0",
                  options.tolerance, options.max_iterations, options.max_rank, options.first_iterations,
                  options.max_evaluations));
}

double grid_evaluations(const StrategySlab& slab, int iterations) {
  double result = static_cast<double>(slab.points()) * iterations;
  for (const int size : slab.sizes()) result *= size;
  return result;
}

void take(const Ending& ending, StrategyResult& result) {
  result.status = ending.status;
  result.message = ending.message;
  result.where = ending.where;
}

/// One slab; the state at its end becomes the start of the next.
void advance(const StrategySlab& slab, Strategy& strategy, const StrategyMarchOptions& options,
             const StrategyCounts& counts, TensorTrain& start, StrategyRecord& record,
             StrategyResult& result) {
  SlabIteration iteration(slab, options, result.rhs_evaluations + result.jacobian_evaluations, counts,
                          record);
  if (options.first != nullptr) iteration.first_iterate(*options.first);
  const std::optional<Ending> failure = iteration.run(strategy);
  record.detail = strategy.detail();
  record.ranks = iteration.iterate().ranks();
  record.status = failure ? failure->status : Termination::converged;
  if (failure) return take(*failure, result);
  record.defect = defect_off_grid(slab, iteration.iterate());
  result.pieces.push_back(field(slab, iteration.iterate()));
  result.reached = record.end;
  start = end_of(slab, iteration.iterate());
}

/// @returns false if a strategy fails already here, the result saying why
bool prepare(const EvolutionProblem& problem, std::initializer_list<Strategy*> strategies, double tolerance,
             StrategyResult& result) {
  result.reached = problem.time.lower();
  for (Strategy* strategy : strategies) {
    if (strategy == nullptr) continue;
    const std::optional<Ending> failure = strategy->prepare(problem, tolerance);
    result.rhs_evaluations += strategy->prepared().rhs;
    result.jacobian_evaluations += strategy->prepared().jacobian;
    if (!failure) continue;
    take(*failure, result);
    return false;
  }
  return true;
}

}  // namespace

std::string Strategy::on_divergence(double ratio) const {
  return fmt::format(
      "corrections grow, by {:.3g} from the last one: {} does not contract on a slab of this "
      "length,",
      ratio, name());
}

StrategyResult solve_by_strategy(const EvolutionProblem& problem, Strategy& strategy,
                                 const StrategyMarchOptions& options) {
  validate(problem, options);
  const Clock::time_point begin = Clock::now();
  StrategyResult result;
  if (!prepare(problem, {options.first, &strategy}, options.tolerance, result)) return result;
  Random random(options.seed);
  TensorTrain start =
      initial_train(problem.initial,
                    Eigen::Map<const Eigen::VectorXd>(problem.scales.data(),
                                                      static_cast<Eigen::Index>(problem.scales.size())),
                    problem.parameters);
  result.status = Termination::converged;
  for (int number = 0; number < problem.time.elements(); ++number) {
    const Clock::time_point slab_begin = Clock::now();
    StrategyCounts counts;
    const StrategySlab slab(problem, number, start, options.tolerance, options.max_rank, random, counts);
    StrategyRecord record{.begin = slab.begin(), .end = slab.begin() + slab.length()};
    advance(slab, strategy, options, counts, start, record, result);
    record.rhs_evaluations = counts.rhs;
    record.jacobian_evaluations = counts.jacobian;
    record.grid_evaluations = grid_evaluations(slab, record.iterations);
    record.seconds = std::chrono::duration<double>(Clock::now() - slab_begin).count();
    result.rhs_evaluations += counts.rhs;
    result.jacobian_evaluations += counts.jacobian;
    result.grid_evaluations += record.grid_evaluations;
    result.status = record.status;
    result.history.push_back(std::move(record));
    if (result.status != Termination::converged) break;
  }
  if (result.status == Termination::converged) {
    result.message = fmt::format("{} slabs, at most {} iterations, defect {:.3g} of the scales",
                                 result.history.size(), result.largest_iterations(), result.largest_defect());
  }
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

int StrategyResult::largest_rank() const {
  int largest = 0;
  for (const StrategyRecord& record : history) {
    for (const int rank : record.ranks) largest = std::max(largest, rank);
  }
  return largest;
}

int StrategyResult::largest_iterations() const {
  int largest = 0;
  for (const StrategyRecord& record : history) largest = std::max(largest, record.iterations);
  return largest;
}

double StrategyResult::largest_contraction() const {
  double largest = 0.0;
  for (const StrategyRecord& record : history) largest = std::max(largest, record.contraction);
  return largest;
}

double StrategyResult::largest_defect() const {
  double largest = 0.0;
  for (const StrategyRecord& record : history) largest = std::max(largest, record.defect);
  return largest;
}

Eigen::VectorXd StrategyResult::value_at(std::span<const double> x) const {
  for (const TrainField& piece : pieces) {
    if (!x.empty() && piece.axes()[0].contains(x[0])) return piece(x);
  }
  throw ArgumentError(fmt::format("the time {} is outside what the march has covered, up to {}",
                                  x.empty() ? 0.0 : x[0], reached));
}

}  // namespace samara::pgd
