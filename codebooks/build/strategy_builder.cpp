#include "samara/codebooks/build/strategy_builder.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/pgd/nonlinear/strategy_march.h"
#include "samara/pgd/tensors/random.h"

namespace samara::codebooks {

namespace {

using pgd::Strategy;
using pgd::StrategyMarchOptions;
using pgd::StrategyResult;

using Factory = std::unique_ptr<Strategy> (*)();

const std::map<std::string, Factory>& factories() {
  static const std::map<std::string, Factory> all = {
      {"incremental", [] { return pgd::incremental_strategy(); }},
      {"polynomial", [] { return pgd::polynomial_strategy(); }},
      {"asymptotic", [] { return pgd::asymptotic_strategy(); }},
      {"empirical", [] { return pgd::empirical_strategy(); }},
      {"piecewise_linear", [] { return pgd::piecewise_linear_strategy(); }},
      {"cross", [] { return pgd::cross_strategy(); }},
  };
  return all;
}

constexpr int kTimePoints = 8;
constexpr int kFirstSlabs = 8;
constexpr int kMostSlabs = 1024;
constexpr int kFirstNodes = 9;
constexpr int kMostNodes = 65;
constexpr int kMostRounds = 12;
/// Of the tolerance: what all slabs together may add, and the sum of the defects left in their equations.
constexpr double kSlabsShare = 0.2;
constexpr double kDefectShare = 0.5;
/// Of the first round, which only finds the ranges of the states.
constexpr double kCoarse = 0.03;
/// Points at which the ranges of the states are looked at.
constexpr int kRangePoints = 500;

/// Sum over the slabs, in scales: about what it does to the solution where motion amplifies nothing.
double total_defect(const StrategyResult& result) {
  double sum = 0.0;
  for (const pgd::StrategyRecord& record : result.history) sum += record.defect;
  return sum;
}

bool is_cut(Termination status) {
  return status == Termination::cancelled || status == Termination::max_calls;
}

/// Slabs and nodes of a round.
struct Grid {
  int slabs = kFirstSlabs;
  std::vector<int> nodes;
};

/// Rounds of marches on finer grids: the best one in one place, the steps as functions.
class Rounds {
 public:
  Rounds(const Plan& plan, const pgd::AdaptiveProblem& problem, long max_evaluations,
         const ProgressCallback& progress)
      : plan_(plan),
        problem_(problem),
        max_evaluations_(max_evaluations),
        progress_(progress),
        strategy_(factories().at(plan.builder.strategy)()),
        scales_(problem.scales) {
    for (const pgd::AdaptiveAxis& axis : problem.parameters)
      grid_.nodes.push_back(axis.nodes.value_or(kFirstNodes));
  }

  Solution run() {
    while (rounds_ < kMostRounds) {
      StrategyResult result = march();
      last_ = result.status;
      last_message_ = result.message;
      const double defect = total_defect(result);
      const bool better = is_better(result);
      if (better) take(std::move(result));
      if (is_cut(last_)) break;
      if (last_ == Termination::converged) {
        // The first round only finds the ranges of the states: tolerances are shares of them.
        if (rounds_ == 1) continue;
        if (!better || defect <= kDefectShare * plan_.relative) break;
      }
      if (!refine(last_)) break;
    }
    return solution();
  }

 private:
  StrategyResult march() {
    ++rounds_;
    pgd::EvolutionProblem problem{
        problem_.system,
        pgd::Axis::radau(problem_.time, 0.0, problem_.end, grid_.slabs, kTimePoints),
        {},
        problem_.states,
        scales_,
        problem_.initial};
    for (std::size_t k = 0; k < grid_.nodes.size(); ++k)
      problem.parameters.push_back(make_axis(problem_.parameters[k], grid_.nodes[k]));
    StrategyMarchOptions options;
    const double tolerance = kSlabsShare * plan_.relative;
    options.tolerance = (rounds_ == 1 ? std::max(kCoarse, tolerance) : tolerance) / grid_.slabs;
    options.seed = plan_.builder.seed;
    if (max_evaluations_ > 0) options.max_evaluations = std::max(1L, max_evaluations_ - evaluations_);
    if (progress_) {
      options.progress = [this](const Progress& report) {
        return progress_({fmt::format("{}, round {}: {} of {}", plan_.builder.strategy, rounds_, report.stage,
                                      grid_.slabs),
                          report.fraction});
      };
    }
    StrategyResult result = solve_by_strategy(problem, *strategy_, options);
    evaluations_ += result.rhs_evaluations + result.jacobian_evaluations;
    grid_evaluations_ += result.grid_evaluations;
    iterations_ = std::max(iterations_, result.largest_iterations());
    return result;
  }

  bool is_better(const StrategyResult& result) const {
    if (result.pieces.empty()) return false;
    if (best_.pieces.empty() || result.reached > best_.reached) return true;
    if (rounds_ == 2) return result.reached == best_.reached;  // in other scales
    return result.reached == best_.reached && total_defect(result) < 0.7 * total_defect(best_);
  }

  void take(StrategyResult result) {
    best_ = std::move(result);
    best_round_ = rounds_;
    measure_ranges();
  }

  /// Scales of the next round: the ranges of the states as far as they are known.
  void measure_ranges() {
    pgd::Random random(plan_.builder.seed);
    const auto states = static_cast<Eigen::Index>(scales_.size());
    Eigen::ArrayXd lowest = Eigen::ArrayXd::Constant(states, HUGE_VAL), highest = -lowest;
    std::vector<double> x(problem_.parameters.size() + 1);
    for (int i = 0; i < kRangePoints; ++i) {
      x[0] = best_.reached * random.uniform();
      for (std::size_t k = 1; k < x.size(); ++k) {
        const pgd::AdaptiveAxis& axis = problem_.parameters[k - 1];
        x[k] = axis.lower + (axis.upper - axis.lower) * random.uniform();
      }
      const Eigen::ArrayXd values = best_.value_at(x).array();
      lowest = lowest.min(values);
      highest = highest.max(values);
    }
    for (std::size_t s = 0; s < scales_.size(); ++s) {
      const auto m = static_cast<Eigen::Index>(s);
      const double range = std::max(highest[m] - lowest[m], problem_.scale_floors[s]);
      if (range > 1e-9 * problem_.scales[s]) scales_[s] = range;
    }
  }

  /// What failed asks for shorter slabs; what converged to a defect, for more nodes too.
  bool refine(Termination status) {
    bool finer = false;
    if (status == Termination::converged) {
      for (std::size_t k = 0; k < grid_.nodes.size(); ++k) {
        if (problem_.parameters[k].nodes || grid_.nodes[k] >= kMostNodes) continue;
        grid_.nodes[k] = std::min(kMostNodes, grid_.nodes[k] * 3 / 2);
        finer = true;
      }
    }
    if (grid_.slabs < kMostSlabs) {
      grid_.slabs *= 2;
      finer = true;
    }
    return finer;
  }

  Solution solution() {
    if (best_.pieces.empty()) {
      throw NoResultError(fmt::format("the strategy \"{}\" has no result on the first slab: {}",
                                      plan_.builder.strategy, last_message_));
    }
    const double defect = total_defect(best_);
    Solution solution;
    BuildRecord& record = solution.record;
    record.builder = "pgd";
    record.strategy = plan_.builder.strategy;
    record.status = best_.status;
    record.message = best_.message;
    if (is_cut(last_) && best_round_ < rounds_) {
      record.status = last_;
      record.message =
          fmt::format("{}; the result is that of round {} of {}", last_message_, best_round_, rounds_);
    } else if (best_.status == Termination::converged && best_round_ == 1) {
      record.status = Termination::missed;
      record.message =
          fmt::format("no round but the first, at a coarse tolerance, gets as far: {}", last_message_);
    } else if (best_.status == Termination::converged && defect > kDefectShare * plan_.relative) {
      record.status = Termination::missed;
      record.message =
          fmt::format("{} leaves a defect of {:.3g} of the ranges in the equations, {:.3g} is wanted",
                      strategy_->name(), defect, kDefectShare * plan_.relative);
    }
    record.evaluations = static_cast<double>(evaluations_);
    record.grid_size = grid_evaluations_;
    record.iterations = iterations_;
    record.rounds = rounds_;
    solution.spent.nonlinearity = defect;
    for (pgd::TrainField& field : best_.pieces) solution.pieces.push_back(Piece{{std::move(field)}});
    return solution;
  }

  const Plan& plan_;
  const pgd::AdaptiveProblem& problem_;
  const long max_evaluations_;
  const ProgressCallback& progress_;
  const std::unique_ptr<Strategy> strategy_;
  std::vector<double> scales_;
  Grid grid_;
  StrategyResult best_;  ///< of the rounds so far
  int best_round_ = 0;
  Termination last_ = Termination::max_iterations;  ///< of the last round
  std::string last_message_;
  int rounds_ = 0;
  int iterations_ = 0;  ///< largest of a slab
  long evaluations_ = 0;
  double grid_evaluations_ = 0.0;
};

}  // namespace

bool is_marched(const std::string& strategy) {
  return factories().contains(strategy);
}

Solution solve_by_strategy(const Plan& plan, const pgd::AdaptiveProblem& problem, const BuildOptions& options,
                           long max_evaluations, const ProgressCallback& progress) {
  // Of a plan of kind "auto" the checkpoint holds the calls of sampling.
  if (plan.builder.kind == "pgd" && options.resume && is_checkpoint(options.checkpoint)) {
    throw ArgumentError(
        fmt::format("{}: a build by the strategy \"{}\" keeps no checkpoint, so it cannot be resumed; remove "
                    "the file or build without --resume",
                    options.checkpoint.string(), plan.builder.strategy));
  }
  check_problem(problem);
  return Rounds(plan, problem, max_evaluations, progress).run();
}

}  // namespace samara::codebooks
