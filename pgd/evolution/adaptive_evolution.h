#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "samara/pgd/evolution/adaptive_problem.h"
#include "samara/pgd/evolution/evolution.h"

/// The evolution solver with axes refined until they resolve the solution.
///
/// Every round solves on the present axes, starting from the field of the round before, and then looks at the
/// highest Legendre coefficients along every axis; axes that do not resolve the field get half as many nodes
/// more. Early rounds are solved only as well as their axes deserve, but every round on new axes takes at
/// least one Newton step: before it, the field is that of the old axes, and its highest coefficients are
/// zero.
namespace samara::pgd {

/// Everything a later round depends on: a value that can be stored and taken up again, with the same end
/// result.
struct SolverState {
  int round = 0;  ///< rounds done
  int time_elements = 4;
  std::vector<int> nodes;  ///< of the parameter axes
  std::vector<double> scales;
  double coarseness = 0.0;  ///< largest highest_coefficients() that the last round refined for; 0 if none
  std::optional<SeparatedField> field;
  long rhs_evaluations = 0;
  long jacobian_evaluations = 0;
  int iterations = 0;
};

struct AdaptiveOptions {
  /// Wanted largest error over the box, in scales of the states; shared out as decided for all builders:
  /// discretisation 0.3, compression 0.3, nonlinearity 0.3, reserve 0.1. Root mean squares inside the solver
  /// are held a factor of `peak_factor` below their share, because errors peak where the solution is hardest.
  double tolerance = 1e-4;
  double peak_factor = 6.0;
  int time_points = 6;  ///< Radau points per time element
  int first_time_elements = 4;
  int first_nodes = 7;
  int max_time_elements = 256;
  int max_nodes = 129;
  int max_rounds = 12;
  /// Of f and J in all rounds, never exceeded; 0: no limit. What the last whole round found is then the
  /// answer.
  long max_evaluations = 0;
  EvolutionOptions evolution = {};                          ///< its tolerance is set by this solver
  std::function<void(const SolverState&)> checkpoint = {};  ///< called after every round that is not the last
};

enum class AdaptiveStatus { converged, evolution_failed, not_resolved, max_evaluations };

struct AxisResolution {
  std::string axis;
  double coefficients = 0.0;  ///< highest_coefficients(), in scales
  int nodes = 0;
};

struct AdaptiveResult {
  EvolutionResult evolution;  ///< of the last round
  AdaptiveStatus status = AdaptiveStatus::not_resolved;
  std::string message;
  std::vector<AxisResolution> resolution;
  SolverState state;
};

/// @param start a state handed to `checkpoint` before, to go on from there; default: from the beginning
/// @throws ArgumentError as solve_evolution() and Axis do, and for a basis that AdaptiveAxis does not name.
AdaptiveResult solve_adaptively(const AdaptiveProblem& problem, const AdaptiveOptions& options = {},
                                SolverState start = {});

}  // namespace samara::pgd
