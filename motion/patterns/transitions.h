#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/motion/patterns/pattern_rules.h"

namespace samara::motion {

/// How often one pattern follows another along falls, and how surely: rows from, columns to, in the order of
/// pattern_names(). One step is a change of label_windows(), so that nothing follows itself; windows that are
/// unresolved are left out, and what stands around them counts as neighbours.
///
/// p_ij = (N_ij + 1/2)/(N_i + (s - 1)/2) for the s patterns of the sequences, j other than i (Dirichlet prior of 1/2);
/// intervals are those of the beta marginals, 2.5 to 97.5 %. A count of 0 is no proof that something cannot happen.
struct Transitions {
  Eigen::MatrixXi counts;
  Eigen::MatrixXd probability, lower, upper;  ///< NaN where a pattern was not seen, or never changes
  /// Changes until a fall with the pattern of the row comes to that of the column, expected under `probability`; NaN
  /// where a pattern that was seen never changes, from which there is no telling.
  Eigen::MatrixXd changes;
  int falls = 0;
};

Transitions transitions(const std::vector<std::vector<Pattern>>& sequences);

}  // namespace samara::motion
