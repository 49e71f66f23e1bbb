#include "samara/identification/solve/starts/global_search.h"

#include <chrono>
#include <cmath>
#include <exception>
#include <memory>
#include <numeric>

#include <nlopt.h>

#include "samara/base/errors.h"
#include "samara/base/parallel.h"
#include "samara/identification/solve/starts/choose_start_states.h"

namespace samara::identification {

namespace {

constexpr int kIterationsOfOwn = 6;
/// Stands for an infinite cost, which NLopt's models of the cost do not bear.
constexpr double kNoTrajectory = 1e30;

nlopt_algorithm algorithm_of(GlobalMethod method) {
  switch (method) {
    case GlobalMethod::direct:
      return NLOPT_GN_DIRECT_L_RAND;
    case GlobalMethod::evolution:
      return NLOPT_GN_ISRES;
    default:
      return NLOPT_GN_CRS2_LM;
  }
}

/// The cost over the shared unknowns, on the unit cube; logarithmic ones by their logarithm.
class SharedCost {
 public:
  SharedCost(const FitProblem& problem, std::vector<SegmentResidual>& residuals, const FitPoint& start)
      : problem_(problem), residuals_(residuals), start_(start), costs_(residuals.size()) {}

  Eigen::VectorXd shared_at(const double* unit) const {
    Eigen::VectorXd shared(problem_.shared_count());
    for (int k = 0; k < problem_.shared_count(); ++k) {
      const models::FamilyCoordinate& c = problem_.shared[static_cast<std::size_t>(k)];
      shared[k] = problem_.shared_chart.is_logarithmic(k) ? c.lower * std::pow(c.upper / c.lower, unit[k])
                                                          : c.lower + (c.upper - c.lower) * unit[k];
    }
    return shared;
  }
  std::vector<double> unit_of(const Eigen::VectorXd& shared) const {
    std::vector<double> unit(static_cast<std::size_t>(shared.size()));
    for (std::size_t k = 0; k < unit.size(); ++k) {
      const models::FamilyCoordinate& c = problem_.shared[k];
      const double value = shared[static_cast<Eigen::Index>(k)];
      const bool logarithmic = problem_.shared_chart.is_logarithmic(static_cast<int>(k));
      unit[k] = logarithmic ? std::log(value / c.lower) / std::log(c.upper / c.lower)
                            : (value - c.lower) / (c.upper - c.lower);
    }
    return unit;
  }

  double operator()(const Eigen::VectorXd& shared) {
    parallel_for(residuals_.size(), [&](std::size_t k) {
      Eigen::VectorXd own = start_.own[k];
      const auto frames = static_cast<int>(residuals_[k].segment().times.size());
      costs_[k] = minimize_own(problem_, residuals_[k], shared, own, frames, kIterationsOfOwn);
    });
    double sum = std::accumulate(costs_.begin(), costs_.end(), 0.0);
    for (const PriorTerm& prior : problem_.priors) sum += 0.5 * std::pow(prior.residual(shared.data()), 2);
    return std::isfinite(sum) ? std::min(sum, kNoTrajectory) : kNoTrajectory;
  }

 private:
  const FitProblem& problem_;
  std::vector<SegmentResidual>& residuals_;
  const FitPoint& start_;
  std::vector<double> costs_;  ///< per segment, so that their sum does not depend on threads
};

/// What NLopt calls, in C.
struct Search {
  SharedCost cost;
  nlopt_opt optimiser = nullptr;
  int budget = 0;
  int evaluations = 0;
  double best_cost = kNoTrajectory;
  Eigen::VectorXd best;
  std::exception_ptr thrown;

  void look_at(const Eigen::VectorXd& shared) {
    const double value = cost(shared);
    ++evaluations;
    last = value;
    if (value >= best_cost) return;
    best_cost = value;
    best = shared;
  }
  double last = kNoTrajectory;
};

double evaluate(unsigned /*size*/, const double* unit, double* /*gradient*/, void* data) {
  Search& search = *static_cast<Search*>(data);
  // Its own counter lets a method finish what it has begun.
  if (search.evaluations >= search.budget) {
    nlopt_force_stop(search.optimiser);
    return kNoTrajectory;
  }
  try {
    search.look_at(search.cost.shared_at(unit));
    return search.last;
  } catch (...) {
    search.thrown = std::current_exception();  // not through C
    nlopt_force_stop(search.optimiser);
    return kNoTrajectory;
  }
}

}  // namespace

GlobalSearch search_box(const FitProblem& problem, std::vector<SegmentResidual>& residuals,
                        const GlobalOptions& options, const FitPoint& start, FitPoint& found) {
  const auto begin = std::chrono::steady_clock::now();
  const auto size = static_cast<unsigned>(problem.shared_count());
  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> optimiser(
      nlopt_create(algorithm_of(options.method), size), &nlopt_destroy);
  Search search{.cost = SharedCost(problem, residuals, start),
                .optimiser = optimiser.get(),
                .budget = options.budget,
                .best = {},
                .thrown = nullptr};
  nlopt_srand(static_cast<unsigned long>(options.seed));
  nlopt_set_lower_bounds1(optimiser.get(), 0.0);
  nlopt_set_upper_bounds1(optimiser.get(), 1.0);
  nlopt_set_min_objective(optimiser.get(), &evaluate, &search);
  nlopt_set_maxeval(optimiser.get(), options.budget);
  nlopt_set_ftol_rel(optimiser.get(), 1e-4);
  std::vector<double> unit = search.cost.unit_of(start.shared);
  double least = 0.0;
  nlopt_optimize(optimiser.get(), unit.data(), &least);
  if (search.thrown) std::rethrow_exception(search.thrown);
  if (search.best.size() > 0) found.shared = search.best;
  return {.method = to_string(options.method),
          .evaluations = search.evaluations,
          .cost = search.best_cost < kNoTrajectory ? search.best_cost : std::nan(""),
          .seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count()};
}

}  // namespace samara::identification
