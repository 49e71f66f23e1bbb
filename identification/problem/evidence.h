#pragma once

#include <string>
#include <utility>
#include <vector>

namespace samara::identification {

/// Of what the evidence is, each sorted.
struct ComparedValues {
  std::vector<std::string> outputs = {};                           ///< "attitude" among them
  std::vector<std::pair<std::string, std::string>> captures = {};  ///< file and id
  bool operator==(const ComparedValues&) const = default;
};

/// How likely a model made what was measured, whatever its unknowns are (FitObjective::evidence()). Of two models of
/// the same values the difference of the logarithms says how many times more likely one made them.
struct Evidence {
  double log = 0.0;              ///< natural logarithm of the density of all compared values, in SI units
  int values = 0;                ///< compared; an attitude counts as three
  ComparedValues compared = {};  ///< whose they are
  int unknowns = 0;              ///< over which the density was integrated, the noise not among them
  double noise_factor = 1.0;     ///< most likely size of the noise, over the loss scales
};

}  // namespace samara::identification
