#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/progress.h"
#include "samara/base/termination.h"
#include "samara/pgd/axes/axis.h"
#include "samara/pgd/fields/separated_field.h"
#include "samara/pgd/linear/enrichment.h"

/// Separated solutions of parametric evolution equations, computed without any trajectory:
///
///   x' = f(t, x, q),  x(0) = x0(q),   t on a time axis, q on parameter axes.
///
/// Newton's iteration on the integral form W = S f(x0 + W), where S integrates the collocation polynomial of
/// the time axis (the inverse of its derivative matrix with W(0) = 0). In each iteration f, and more loosely
/// its Jacobian, are brought to separated form by cross interpolation from values at chosen entries; the
/// linear problem (I - S J) dW = S f - W is solved by enrichment; the sum is compressed. The full grid is
/// never visited; the number of evaluations is reported.
namespace samara::pgd {

class PolynomialSystem;

/// What the engine must know of the equations: f and df/dx at batches of points. Implementations must be
/// const-safe.
class EvolutionSystem {
 public:
  virtual ~EvolutionSystem() = default;
  virtual int state_count() const = 0;
  /// @param t one time per point; @param x states x points; @param q parameters x points
  /// @param f states x points, set by the call
  virtual void rhs(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                   Eigen::MatrixXd& f) const = 0;
  /// @param jacobian column j holds df/dx at point j, states x states, column after column
  virtual void jacobian(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                        Eigen::MatrixXd& jacobian) const = 0;
  /// Whether f = f_0 + sum_k q_k f_k with f_k independent of q, for all parameters together.
  virtual bool affine_in_parameters() const { return false; }
  /// The same system term by term if its f is a polynomial; null: it is not, or is not known to be.
  virtual const PolynomialSystem* polynomial() const { return nullptr; }
};

/// x0 of one state: a number, or the coordinate of one of the parameter axes.
struct InitialValue {
  double value = 0.0;
  int axis = -1;  ///< index into EvolutionProblem::parameters; negative: `value`
};

struct EvolutionProblem {
  const EvolutionSystem* system = nullptr;
  Axis time;  ///< must start where the initial values hold; made of elements, without a transform
  std::vector<Axis> parameters;
  std::vector<OutputLabel> states;
  std::vector<double> scales;  ///< characteristic size of each state; errors are measured in it
  std::vector<InitialValue> initial;

  /// @throws ArgumentError if sizes do not match, a scale is not positive, or the time axis is of another
  /// kind.
  void validate() const;
};

struct EvolutionOptions {
  /// Stop when the root mean square of S f(x0 + W) - W over the box is below this, in scales of the states.
  double tolerance = 1e-6;
  int max_iterations = 25;
  int max_rank = 150;
  /// Products of the linear problems' right-hand sides and Jacobians. Their cost grows with the square of
  /// this number, and the products of a train with the product of its ranks.
  int max_terms = 3000;
  /// The integral form is the identity plus a smoothing operator, for which Galerkin is safe; and it keeps
  /// the causal structure in time, so that the factor updates of the time axis are solved element by element.
  Projection projection = Projection::galerkin;
  /// Relative residual asked of the linear solves, and relative accuracy of the Jacobian: together they set
  /// the contraction of the inexact Newton iteration.
  double linear_tolerance = 0.1;
  std::uint64_t seed = 1;
  /// Also asked between the evaluations and the linear problems' terms of an iteration, which may take long.
  ProgressCallback progress = {};
};

struct EvolutionRecord {
  double residual = 0.0;  ///< before the step, in scales
  double step = 1.0;      ///< fraction of the Newton step that led here
  int rank = 0;           ///< of the iterate
  int rhs_terms = 0;      ///< of the linear problem
  int jacobian_terms = 0;
  EnrichTermination linear = EnrichTermination::residual;
  double linear_residual = 0.0;  ///< in scales
  long evaluations = 0;          ///< of f and J in this iteration
  double seconds = 0.0;
};

struct EvolutionResult {
  SeparatedField field;  ///< axes: time, then the parameters; outputs: the states, SI
  /// converged, max_iterations, diverged (the residual grows even with shortened steps: the solution may not
  /// exist on the whole box), not_finite, stagnated (the linear solves no longer reduce the residual),
  /// rank_limit (f or its Jacobian takes more products than max_terms) or cancelled.
  Termination status = Termination::diverged;
  std::string message;
  std::vector<EvolutionRecord> history;
  /// Last one, in scales: what the truncation to finitely many terms leaves of the equations; 1 if the solve
  /// ended before there was one.
  double residual = 0.0;
  double nonlinearity_error = 0.0;  ///< guard error of f times the duration, in scales
  long rhs_evaluations = 0;
  long jacobian_evaluations = 0;
  double grid_size = 0.0;  ///< nodes of time x parameters
  double seconds = 0.0;
};

/// @param guess a field over axes of the same names (any nodes) to start from, or null
/// @throws ArgumentError if problem or options do not validate, or the guess has other axes or outputs.
EvolutionResult solve_evolution(const EvolutionProblem& problem, const EvolutionOptions& options = {},
                                const SeparatedField* guess = nullptr);

}  // namespace samara::pgd
