#include "samara/identification/problem/prior_terms.h"

#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/problem/fit_problem.h"

namespace samara::identification {

namespace {

void add_prior(const std::string& name, const Prior& prior, FitProblem& problem) {
  const std::optional<std::size_t> shared = position(problem.shared, name);
  const std::optional<std::size_t> own = position(problem.own, name);
  if (!shared && !own) {
    std::vector<std::string> known = names_of(problem.shared);
    for (const std::string& other : names_of(problem.own)) known.push_back(other);
    throw ArgumentError(
        fmt::format("priors: \"{}\" is not a free coordinate{}", name, suggestion(name, known)));
  }
  if (own && problem.own_chart.is_part_of_quaternion(static_cast<int>(*own))) {
    throw ArgumentError(fmt::format(
        "priors: \"{}\" is a part of an attitude; a coordinate that moves by itself was expected", name));
  }
  const models::FamilyCoordinate& c = shared ? problem.shared[*shared] : problem.own[*own];
  if (prior.logarithmic && !(c.lower > 0.0)) {
    throw ArgumentError(
        fmt::format("priors: \"{}\" has a logarithmic prior, but its box begins at {}; a positive number "
                    "was expected",
                    name, c.lower));
  }
  (shared ? problem.priors : problem.own_priors)
      .emplace_back(static_cast<int>(shared ? *shared : *own), prior);
}

void add_combination(const CombinationPrior& prior, FitProblem& problem) {
  std::vector<PriorTerm::Weight> weights;
  for (const auto& [name, weight] : prior.weights) {
    const std::optional<std::size_t> shared = position(problem.shared, name);
    if (!shared) {
      throw ArgumentError(fmt::format("combinations: \"{}\" is not a shared coordinate{}", name,
                                      suggestion(name, names_of(problem.shared))));
    }
    weights.push_back({static_cast<int>(*shared), weight});
  }
  problem.priors.emplace_back(std::move(weights), prior.mean, prior.deviation);
}

}  // namespace

PriorTerm::PriorTerm(int unknown, const Prior& prior)
    : weights_{{unknown, 1.0}},
      mean_(prior.mean),
      deviation_(prior.deviation),
      logarithmic_(prior.logarithmic) {}

PriorTerm::PriorTerm(std::vector<Weight> sum, double mean, double deviation)
    : weights_(std::move(sum)), mean_(mean), deviation_(deviation) {}

double PriorTerm::sum(const double* unknowns) const {
  double sum = 0.0;
  for (const auto& [unknown, weight] : weights_) sum += weight * unknowns[unknown];
  return sum;
}

double PriorTerm::residual(const double* unknowns) const {
  const double value = sum(unknowns);
  return (logarithmic_ ? std::log(value / mean_) : value - mean_) / deviation_;
}

double PriorTerm::slope(const double* unknowns) const {
  return 1.0 / (logarithmic_ ? sum(unknowns) * deviation_ : deviation_);
}

PriorTerm PriorTerm::moved(double deviations) const {
  PriorTerm other = *this;
  const double step = deviations * deviation_;
  other.mean_ = logarithmic_ ? mean_ * std::exp(step) : mean_ + step;
  return other;
}

void add_priors(const FitOptions& options, FitProblem& problem) {
  for (const auto& [name, prior] : options.priors.coordinates) {
    if (!options.unknowns.known.contains(name)) add_prior(name, prior, problem);
  }
  for (const CombinationPrior& prior : options.priors.combinations) add_combination(prior, problem);
}

}  // namespace samara::identification
