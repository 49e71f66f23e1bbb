#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "samara/base/progress.h"
#include "samara/pgd/linear_problem.h"
#include "samara/pgd/separated_tensor.h"

/// The linear solver: greedy enrichment with an alternating-direction fixed point, the dissertation's
/// Algorithm 3.
///
/// One term after another is found as the best product in the sense of the projection, (6.11)-(6.13),
/// normalised (6.14); then all weights are projected together (6.15), and, beyond the dissertation, the
/// factors of all modes are updated together, one mode after the other, which about halves the rank. The
/// residual (6.16) decides.
///
/// Usage:
///   LinearProblem problem{op, rhs, {}};
///   EnrichResult result = enrich(problem, {.residual_tolerance = 1e-6});
///   if (result.termination != Termination::residual) report(result.message);
namespace samara::pgd {

struct EnrichOptions {
  Projection projection = Projection::minimal_residual;

  // When to stop.
  /// ||D U - G|| <= residual_tolerance * ||G||.
  double residual_tolerance = 1e-8;
  /// |newest weight| < amplitude_tolerance * largest weight. Zero: not used.
  double amplitude_tolerance = 0.0;
  int max_rank = 60;
  /// Stops if the last `stagnation_terms` terms together lowered the residual by less than 5 %.
  int stagnation_terms = 4;

  // The fixed point of one term.
  int max_fixed_point_iterations = 20;
  /// Change of the product between two iterations, relative to its size.
  double fixed_point_tolerance = 1e-2;

  // After each term.
  /// Sweeps of factor updates over all modes; 0 projects the weights only, as the dissertation does.
  int update_sweeps = 2;

  std::uint64_t seed = 1;  ///< of the first guesses
  ProgressCallback progress = {};
};

enum class Termination {
  residual,    ///< the residual tolerance is met
  amplitude,   ///< new terms no longer matter by the amplitude tolerance
  max_rank,    ///< the allowed number of terms is used up
  stagnation,  ///< new terms no longer lower the residual
  singular,    ///< the 1-D problems could not be solved
  cancelled,   ///< the progress callback asked for it
};

struct TermRecord {
  double amplitude = 0.0;  ///< weight of the new term before the projection
  int fixed_point_iterations = 0;
  bool fixed_point_converged = false;
  double residual = 0.0;  ///< relative, after projection and update
  double seconds = 0.0;
};

struct EnrichResult {
  SeparatedTensor solution;
  Termination termination = Termination::singular;
  std::string message = "enrich() was not called";
  double residual = 1.0;  ///< relative, of `solution`
  std::vector<TermRecord> history;
  double seconds = 0.0;
};

/// Solves D(U) = G. An empty or zero right-hand side gives the solution without terms and
/// Termination::residual.
/// @throws ArgumentError if the problem does not validate, or an option is out of range.
EnrichResult enrich(const LinearProblem& problem, const EnrichOptions& options = {},
                    const SeparatedTensor* start = nullptr);

std::string to_string(Termination termination);

}  // namespace samara::pgd
