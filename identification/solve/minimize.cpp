#include "samara/identification/solve/minimize.h"

#include <limits>
#include <memory>
#include <string>
#include <utility>

#include <ceres/ceres.h>

#include "samara/identification/problem/box_bounds.h"
#include "samara/identification/solve/ceres_terms.h"
#include "samara/identification/solve/separable_descent.h"

namespace samara::identification {

namespace {

/// Solutions after the first, with other unknowns held at bounds.
constexpr int kMostPasses = 20;
/// Letting go of a bound is worth it from this gain of the cost, relatively.
constexpr double kGain = 1e-9;

ceres::Problem::Options ownership(Evaluation& evaluation) {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.evaluation_callback = &evaluation;
  return options;
}

ceres::Solver::Options solver_options(const FitProblem& problem, int max_iterations, double tolerance) {
  ceres::Solver::Options options;
  options.max_num_iterations = max_iterations;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.minimizer_progress_to_stdout = false;
  options.function_tolerance = tolerance;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-11;
  // Shared unknowns alone, or small blocks in a chain.
  options.linear_solver_type = problem.own_count() == 0 ? ceres::DENSE_QR : ceres::SPARSE_NORMAL_CHOLESKY;
  return options;
}

Termination status_of(const ceres::Solver::Summary& summary) {
  switch (summary.termination_type) {
    case ceres::CONVERGENCE:
    case ceres::USER_SUCCESS:
      return Termination::converged;
    case ceres::NO_CONVERGENCE:
      return Termination::max_iterations;
    default:
      return Termination::failed;
  }
}

/// A block of unknowns, and those of it that are held at a bound.
struct Block {
  double* values;
  const std::vector<models::FamilyCoordinate>* coordinates;
  const Chart* chart;  ///< with nothing held
  std::vector<char> held;
  std::unique_ptr<ChartManifold> manifold = {};  ///< none where unknowns move by adding

  std::vector<char> at_bounds() const {
    return identification::at_bounds(*coordinates, *chart,
                                     Eigen::Map<const Eigen::VectorXd>(values, chart->size()));
  }
};

/// Ceres clips its steps to the box: where unknowns hang together, a clipped step is none of descent, and the
/// steps dwindle before the minimum. So what has reached a bound is held there, the rest is minimised again,
/// and what then pulls inwards is let go, until neither changes.
class Descent {
 public:
  Descent(const FitProblem& problem, const std::vector<SegmentResidual>& residuals, Unknowns& unknowns,
          Evaluation& evaluation)
      : problem_(problem), evaluation_(evaluation), ceres_(ownership(evaluation)) {
    add_costs(residuals, unknowns);
    if (problem.shared_count() > 0) add_block(unknowns.shared(), problem.shared, problem.shared_chart);
    for (std::size_t k = 0; problem.own_count() > 0 && k < residuals.size(); ++k) {
      add_block(unknowns.own(k), problem.own, problem.own_chart);
    }
  }

  MinimizeResult run(const ceres::Solver::Options& options) {
    MinimizeResult result;
    solve(options, result);
    double cost_at_release = std::numeric_limits<double>::infinity();
    for (int pass = 0; result.status == Termination::converged; ++pass) {
      bool changed = hold_what_is_at_bounds();
      if (!changed && pass > 0) {
        changed = result.cost < (1.0 - kGain) * cost_at_release && release(result.cost);
        cost_at_release = result.cost;
      }
      if (!changed) break;
      if (pass == kMostPasses) {
        result.status = Termination::max_iterations;
        result.message = "unknowns kept coming to bounds of the box and leaving them";
        break;
      }
      solve(options, result);
    }
    return result;
  }

 private:
  void add_costs(const std::vector<SegmentResidual>& residuals, Unknowns& unknowns) {
    for (std::size_t k = 0; k < residuals.size(); ++k) {
      costs_.push_back(std::make_unique<SegmentCost>(problem_, residuals[k], evaluation_, k));
      std::vector<double*> blocks;
      if (problem_.shared_count() > 0) blocks.push_back(unknowns.shared());
      if (problem_.own_count() > 0) blocks.push_back(unknowns.own(k));
      if (residuals[k].segment().joined) blocks.push_back(unknowns.own(k + 1));
      ceres_.AddResidualBlock(costs_.back().get(), nullptr, blocks);
    }
    if (!problem_.priors.empty()) {
      costs_.push_back(std::make_unique<PriorCost>(problem_));
      ceres_.AddResidualBlock(costs_.back().get(), nullptr, unknowns.shared());
    }
  }

  /// With its bounds; not of what a quaternion consists of, which moves on the sphere.
  void add_block(double* values, const std::vector<models::FamilyCoordinate>& coordinates,
                 const Chart& chart) {
    blocks_.push_back(
        {values, &coordinates, &chart, std::vector<char>(static_cast<std::size_t>(chart.size()))});
    for (int k = 0; k < static_cast<int>(coordinates.size()); ++k) {
      if (chart.is_part_of_quaternion(k)) continue;
      ceres_.SetParameterLowerBound(values, k, coordinates[static_cast<std::size_t>(k)].lower);
      ceres_.SetParameterUpperBound(values, k, coordinates[static_cast<std::size_t>(k)].upper);
    }
    move_freely(blocks_.back(), chart);
  }

  void move_freely(Block& block, const Chart& chart) {
    auto manifold = chart.is_linear() ? nullptr : std::make_unique<ChartManifold>(chart);
    ceres_.SetManifold(block.values, manifold.get());
    block.manifold = std::move(manifold);
  }

  void solve(const ceres::Solver::Options& options, MinimizeResult& result) {
    for (Block& block : blocks_) {
      Chart chart = *block.chart;
      for (int k = 0; k < chart.size(); ++k) {
        if (block.held[static_cast<std::size_t>(k)]) chart = chart.holding(k);
      }
      move_freely(block, chart);
    }
    ceres::Solver::Summary summary;
    ceres::Solve(options, &ceres_, &summary);
    evaluation_.rethrow();
    result.status = status_of(summary);
    result.message = summary.message;
    if (result.message.ends_with('.')) result.message.pop_back();
    const std::string failure = evaluation_.failure();
    if (result.status == Termination::failed && !failure.empty())
      result.message += "; at the last point tried " + failure;
    result.cost = summary.final_cost;
    result.iterations += summary.num_successful_steps + summary.num_unsuccessful_steps;
  }

  /// @returns whether any was not held before
  bool hold_what_is_at_bounds() {
    bool changed = false;
    for (Block& block : blocks_) {
      const std::vector<char> at = block.at_bounds();
      for (std::size_t k = 0; k < at.size(); ++k) {
        if (!at[k] || block.held[k] || block.chart->direction_of(static_cast<int>(k)) < 0) continue;
        block.held[k] = 1;
        changed = true;
      }
    }
    return changed;
  }

  /// Lets go of what would lower the cost by moving into the box: by g^2/(2 h), with g the slope and h the
  /// curvature J^T J of that unknown alone.
  /// @returns whether there was any
  bool release(double cost) {
    ceres::Problem::EvaluateOptions options;
    for (Block& block : blocks_) {
      move_freely(block, *block.chart);
      if (block.chart->directions() > 0) options.parameter_blocks.push_back(block.values);
    }
    std::vector<double> gradient;
    ceres::CRSMatrix jacobian;
    if (!ceres_.Evaluate(options, nullptr, nullptr, &gradient, &jacobian)) return false;
    std::vector<double> curvature(gradient.size(), 0.0);
    for (std::size_t k = 0; k < jacobian.values.size(); ++k) {
      curvature[static_cast<std::size_t>(jacobian.cols[k])] += jacobian.values[k] * jacobian.values[k];
    }
    bool changed = false;
    std::size_t first = 0;
    for (Block& block : blocks_) {
      for (std::size_t k = 0; k < block.coordinates->size(); ++k) {
        if (!block.held[k]) continue;
        const std::size_t at =
            first + static_cast<std::size_t>(block.chart->direction_of(static_cast<int>(k)));
        const models::FamilyCoordinate& c = (*block.coordinates)[k];
        const bool at_lower = block.values[k] < 0.5 * (c.lower + c.upper);
        const bool inwards = at_lower ? gradient[at] < 0.0 : gradient[at] > 0.0;
        const double gain = curvature[at] > 0.0 ? 0.5 * gradient[at] * gradient[at] / curvature[at] : 0.0;
        if (!inwards || gain <= kGain * cost) continue;
        block.held[k] = 0;
        changed = true;
      }
      first += static_cast<std::size_t>(block.chart->directions());
    }
    return changed;
  }

  const FitProblem& problem_;
  Evaluation& evaluation_;
  std::vector<std::unique_ptr<ceres::CostFunction>> costs_;
  std::vector<Block> blocks_;
  ceres::Problem ceres_;
};

}  // namespace

MinimizeResult minimize(const FitProblem& problem, std::vector<SegmentResidual>& residuals, FitPoint start,
                        int max_iterations, Precision precision) {
  if (problem.own_count() > 0 && !problem.is_joined()) {
    constexpr double kShare = 0.01, kRoughShare = 0.1;
    return minimize_separably(problem, residuals, std::move(start), max_iterations,
                              precision == Precision::full ? kShare : kRoughShare);
  }
  constexpr double kChange = 1e-11, kRoughChange = 1e-7;
  const double tolerance = precision == Precision::full ? kChange : kRoughChange;
  Unknowns unknowns(start, problem.shared_count(), problem.own_count());
  Evaluation evaluation(residuals, unknowns);
  // Ceres would complain about such a start on stderr.
  if (!evaluation.all_are_finite()) return {.point = std::move(start), .message = evaluation.failure()};
  Descent descent(problem, residuals, unknowns, evaluation);
  MinimizeResult result = descent.run(solver_options(problem, max_iterations, tolerance));
  result.point = std::move(start);
  unknowns.store(result.point);
  return result;
}

}  // namespace samara::identification
