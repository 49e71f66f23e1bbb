#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "samara/base/progress.h"
#include "samara/base/termination.h"
#include "samara/pgd/evolution/evolution.h"
#include "samara/pgd/fields/separated_field.h"
#include "samara/pgd/linear/enrichment.h"

/// Decoupling of coupled equations, (6.17) of the dissertation: every unknown has a separated field of its
/// own over time and parameters, and its equation is solved by itself,
///
///   u_m' = a_m(q) u_m + g_m(t, q),
///
/// where g_m holds the constants and all coupled (and nonlinear) terms, as products of the last known
/// fields: of this iteration for the unknowns before m, of the last one for those behind it (Gauss-Seidel).
/// Products are compressed at once. Each of these linear problems, in its integral form, is solved by
/// enrichment (Algorithm 3), started from the unknown's last field.
///
/// It is a Picard iteration: it converges for short times or weak coupling, and reports its contraction. The
/// time axis may be taken slab by slab, the end of one the start of the next; where that does not contract
/// either, take Newton's iteration (solve_evolution) or solve_by_slabs.
///
///   const PolynomialSystem system(3, 3, {{0, 1.0}, {0, -1.0, {}, {0, 1, 1}}, ..});
///   const DecouplingResult result = solve_decoupled({&system, time, ..}, {.tolerance = 1e-7, .slabs = 4});
///   if (result.status != Termination::converged) report(result.message);
namespace samara::pgd {

/// How unknowns are held between iterations.
enum class DecoupledForm {
  /// Sums of products, found by enrichment, as in the dissertation.
  sums,
  /// Trains. What an unknown does to itself is a source like the rest, so that there is nothing to solve:
  /// the collocation's integration of the sources is the next field. Much faster where accuracy asks for many
  /// terms; the fields handed out are sums again, of more terms.
  trains,
};

struct DecouplingOptions {
  /// Root mean square over the nodes of the box, in scales, of what another iteration would still change;
  /// largest errors are some ten times that.
  double tolerance = 1e-7;
  /// Parts of the time axis that are solved one after the other; its elements are shared out among them.
  int slabs = 1;
  int max_iterations = 60;  ///< per slab
  DecoupledForm form = DecoupledForm::sums;
  int max_rank = 300;  ///< terms of one unknown, or ranks of its train
  /// Of the linear problems: their integral form is the identity plus a smoothing operator, for which both
  /// are safe.
  Projection projection = Projection::galerkin;
  /// Corrections may grow this many times in a row before the iteration counts as divergent.
  int patience = 4;
  std::uint64_t seed = 1;
  ProgressCallback progress = {};
};

/// One iteration over all unknowns.
struct DecouplingRecord {
  int slab = 0;
  double correction = 0.0;  ///< root mean square in scales, of the unknown that changed most
  /// Its ratio to the one before; 0 in the first iteration of a slab, and behind a correction below
  /// `accuracy`.
  double contraction = 0.0;
  double accuracy = 0.0;       ///< asked of products and linear problems
  double linear_residual = 0;  ///< largest of the linear problems, root mean square in scales
  std::vector<int> terms;      ///< of every unknown; of trains, its largest rank
  int source_terms = 0;        ///< largest number of products in a source after compression
  double seconds = 0.0;
};

struct DecouplingResult {
  /// Per slab that was solved, one field per unknown, over time and the parameters, SI.
  std::vector<std::vector<SeparatedField>> slabs;
  /// converged, max_iterations, diverged, rank_limit (the linear problems are not solved well enough with the
  /// allowed terms) or cancelled.
  Termination status = Termination::max_iterations;
  std::string message = "solve_decoupled() was not called";
  /// Time and parameters of the largest last correction, if the iteration diverged.
  std::vector<double> where;
  double reached = 0.0;  ///< end of the last slab that was solved
  std::vector<DecouplingRecord> history;
  double seconds = 0.0;

  int largest_iterations() const;      ///< of a slab
  double largest_contraction() const;  ///< below one where the iteration contracts
  int largest_rank() const;
  /// All unknowns at (time, parameters..). @throws ArgumentError if the time is not covered.
  Eigen::VectorXd value_at(std::span<const double> x) const;
};

/// @throws ArgumentError if the problem or an option does not validate, the time axis is not of the radau
/// kind or has fewer elements than there are slabs, or the system is not a polynomial known term by term
/// (EvolutionSystem::polynomial): of other systems products of fields do not make f.
DecouplingResult solve_decoupled(const EvolutionProblem& problem, const DecouplingOptions& options = {});

}  // namespace samara::pgd
