#pragma once

#include <Eigen/Core>

#include "samara/pgd/evolution/slab_evolution.h"

namespace samara::pgd {

/// What some guard points by themselves tell before a march, at a small part of its cost.
struct GuardSurvey {
  Eigen::VectorXd ranges;  ///< of the states, in the scales given
  /// The error at the end over what every slab adds to it, in ranges: the largest factors by which neighbours part
  /// from the end of each slab to that of the time, added as errors are that have nothing to do with each other.
  double growth = 1.0;
  long evaluations = 0;
  bool cancelled = false;
};

/// Marches the corners of the box and a quarter as many random points as a cell has guards, each with a neighbour
/// in a random direction, from their starts to the end of the time or as far as they go.
/// @param scales what errors are measured in @param tolerance of a slab, in scales
GuardSurvey survey_guards(const AdaptiveProblem& problem, const SlabOptions& options,
                          const SlabSolver& solver, const Eigen::VectorXd& scales, double tolerance);

}  // namespace samara::pgd
