#pragma once

#include <map>
#include <string>
#include <vector>

/// What is known of unknowns beforehand. As residuals priors stand in prior_terms.h, as text in prior_formats.h; what
/// asks for more than residuals is solve/laplace_evidence.cpp and solve/uncertainty.cpp (priors of several unknowns).
namespace samara::identification {

/// What is known of a coefficient beforehand: a normal distribution of it, or of its logarithm.
struct Prior {
  double mean = 0.0;       ///< SI; the median if logarithmic
  double deviation = 1.0;  ///< standard deviation, SI; of the logarithm if logarithmic: 0.1 is 10 %
  bool logarithmic = false;
};

/// Of the value itself, SI: of a logarithmic prior to first order in its deviation.
double standard_deviation(const Prior& prior);

/// What is known beforehand of a sum of shared coordinates: it is normal. Differences of neighbours in a row
/// of coordinates make the row smooth.
struct CombinationPrior {
  std::map<std::string, double> weights = {};  ///< by name; of SI values
  double mean = 0.0;                           ///< of the weighted sum
  double deviation = 1.0;
};

/// What is known of unknowns before the captures are seen.
struct PriorOptions {
  /// By coordinate: of shared ones, and of those of each capture's own. There the prior is the same for every
  /// capture, and holds where its first segment starts. Of known coordinates: for captures left out that lack
  /// the value.
  std::map<std::string, Prior> coordinates = {};
  std::vector<CombinationPrior> combinations = {};
};

/// @throws ArgumentError naming the deviation or mean that is none.
void validate(const PriorOptions& priors);

}  // namespace samara::identification
