#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "samara/base/progress.h"
#include "samara/base/termination.h"
#include "samara/pgd/linear/acceleration.h"
#include "samara/pgd/linear/linear_problem.h"
#include "samara/pgd/linear/sparse_solver.h"
#include "samara/pgd/tensors/separated_tensor.h"

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
///   if (result.termination != Termination::converged) report(result.message);
namespace samara::pgd {

/// How the residual that decides is computed; see residual.h.
enum class ResidualKind {
  resolved,  ///< by inner products, below 1e-6 by orthogonalisation
  fast,      ///< by inner products: cheap, blind below about 1e-8
  exact,     ///< by orthogonalisation
};

struct TermRecord {
  double amplitude = 0.0;  ///< weight of the new term before the projection
  int fixed_point_iterations = 0;
  bool fixed_point_converged = false;
  double residual = 0.0;  ///< relative, after projection and update
  double seconds = 0.0;
};

/// All that a solve knows between two terms: from it enrich() goes on to the same result, to the last bit.
struct EnrichState {
  SeparatedTensor solution;
  double residual = 1.0;           ///< relative, of `solution`
  std::uint64_t random_state = 0;  ///< of the first guesses
  double largest_amplitude = 0.0;
  std::vector<TermRecord> history;  ///< one record for each term that was added
  /// An earlier solution with a lower residual than `solution`, if there is one: Galerkin's may rise.
  SeparatedTensor best;
  double best_residual = std::numeric_limits<double>::infinity();
};

struct EnrichOptions {
  Projection projection = Projection::minimal_residual;

  // When to stop.
  /// ||D U - G|| <= residual_tolerance * ||G||. A residual is never taken for smaller than the rounding of D
  /// U.
  double residual_tolerance = 1e-8;
  ResidualKind residual = ResidualKind::resolved;
  /// |newest weight| < amplitude_tolerance * largest weight. Zero: not used.
  double amplitude_tolerance = 0.0;
  int max_rank = 60;
  /// Stops before the next term once so many seconds have passed. Zero: not used.
  double max_seconds = 0.0;
  /// Stops if the last `stagnation_terms` terms together lowered the residual by less than 5 %.
  int stagnation_terms = 4;

  // The fixed point of one term.
  int max_fixed_point_iterations = 20;
  /// Change of the product between two iterations, relative to its size.
  double fixed_point_tolerance = 1e-2;
  Acceleration acceleration = Acceleration::none;
  /// Random first guesses per term, at most 1000; the product that gains most is taken.
  int first_guesses = 1;

  // After each term.
  /// Most sweeps of factor updates over all modes; 0 projects the weights only, as the dissertation does.
  int update_sweeps = 2;
  /// Ends the sweeps once one changes the weights by less than this, relative to the largest; 0: never.
  double update_tolerance = 0.0;

  SparseSolverKind solver = SparseSolverKind::automatic;  ///< on sparse axes
  std::uint64_t seed = 1;                                 ///< of the first guesses
  ProgressCallback progress = {};
  std::function<void(const EnrichState&)> checkpoint = {};  ///< called after every term
};

struct EnrichResult {
  SeparatedTensor solution;
  /// converged (to the residual, or new terms no longer matter), rank_limit, max_seconds, stagnated (new terms no
  /// longer lower the residual), failed (a 1-D problem is singular), cancelled
  Termination termination = Termination::failed;
  std::string message = "enrich() was not called";
  double residual = 1.0;  ///< relative, of `solution`
  std::vector<TermRecord> history;
  double seconds = 0.0;
};

/// Solves D(U) = G. A right-hand side without terms, or whose terms cancel to rounding, gives the solution
/// without terms and Termination::converged. The solution returned is the one with the lowest residual of all
/// that were met after a term.
/// @param start a first approximation (warm start), whose terms are projected and updated first
/// @throws ArgumentError if the problem does not validate, or an option is out of range.
EnrichResult enrich(const LinearProblem& problem, const EnrichOptions& options = {},
                    const SeparatedTensor* start = nullptr);

/// Goes on from a checkpoint of the same problem and options.
/// @throws ArgumentError as above, or if the state's residual is not that of its solution in this problem.
EnrichResult enrich(const LinearProblem& problem, const EnrichOptions& options, const EnrichState& state);

}  // namespace samara::pgd
