#pragma once

#include <string>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/axes/quadrature.h"

namespace samara::codebooks {

enum class DistributionKind { uniform, normal, log_normal };

/// How one input of a codebook is distributed. Of a normal or log-normal one the part inside the box counts.
struct Distribution {
  DistributionKind kind = DistributionKind::uniform;
  /// Least value; mean; median. SI.
  double first = 0.0;
  /// Largest value; standard deviation, > 0, both SI; of log-normal ones that of the logarithm, > 0.
  double second = 1.0;
};

/// "uniform", "normal" or "lognormal". @throws ArgumentError for another name
DistributionKind distribution_from_string(const std::string& name);

/// "uniform(0.9, 1.1)", "normal(1.1, 0.05)", "lognormal(0.001, 0.2)": numbers in SI.
std::string to_string(const Distribution& distribution);

/// @param what whose it is, for the message
/// @throws ArgumentError for numbers that are not finite, a least value not below the largest, a deviation or the
///   median of a log-normal one not above 0, or a deviation of its logarithm above 100
void require_distribution(const std::string& what, const Distribution& distribution);
/// @throws ArgumentError if the axis is a list of values
void require_no_list(const pgd::Axis& axis);

/// The probability of values up to x.
double probability_below(const Distribution& distribution, double x);
/// The value below which lies the probability `share`, in (0, 1). Its inverse.
double quantile_of(const Distribution& distribution, double share);

/// A quadrature rule on the axis for what lies on it of the distribution: weights sum to one. Exact to about 1e-11 for
/// products of two functions of the axis, also under a transform.
/// @throws ArgumentError if the axis is a list of values, or none of the distribution lies on it
pgd::QuadratureRule rule_of(const Distribution& distribution, const pgd::Axis& axis);

}  // namespace samara::codebooks
