#pragma once

#include <string>
#include <utility>
#include <vector>

#include "samara/identification/problem/fit_options.h"

/// Internal to identification/: what is known of unknowns beforehand, as residuals beside those of the frames.
namespace samara::identification {

struct FitProblem;

/// One residual: (sum of weight * unknown - mean)/deviation, or log(unknown/mean)/deviation. All parts of a
/// fit that know of priors go through it.
class PriorTerm {
 public:
  struct Weight {
    int unknown = 0;
    double weight = 1.0;
  };

  /// Of one unknown.
  PriorTerm(int unknown, const Prior& prior);
  /// Of a weighted sum of unknowns.
  PriorTerm(std::vector<Weight> sum, double mean, double deviation);

  const std::vector<Weight>& weights() const { return weights_; }
  double residual(const double* unknowns) const;
  /// d residual/d(weighted sum): times a weight, the derivative by an unknown.
  double slope(const double* unknowns) const;
  /// The same prior with its mean moved by so many deviations.
  PriorTerm moved(double deviations) const;

 private:
  double sum(const double* unknowns) const;

  std::vector<Weight> weights_;
  double mean_, deviation_;
  bool logarithmic_ = false;
};

/// Those of the options into the problem: first the single coordinates, then combinations.
/// @throws ArgumentError for a prior of what is not free or part of an attitude, for one outside its meaning,
/// and for a combination of what is not shared.
void add_priors(const FitOptions& options, FitProblem& problem);

}  // namespace samara::identification
