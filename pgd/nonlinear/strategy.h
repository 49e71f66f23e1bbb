#pragma once

#include <memory>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "samara/pgd/nonlinear/strategy_slab.h"

/// Strategies for nonlinear terms: each turns the current iterate X of a slab into a linear problem for the
/// next one,
///
///   X' = A(t, q) X + b(t, q),  A and b separated,
///
/// of which the solution over the whole parameter box is the next iterate (dissertation, section 6.5).
///
/// | factory                  | A                        | b                                                |
/// | ------------------------ | ------------------------ | ------------------------------------------------ |
/// | incremental_strategy     | none                     | f(X), by products where f is a polynomial        |
/// | polynomial_strategy      | J at one state           | the rest of Taylor's expansion of order 1 or 2   |
/// | asymptotic_strategy      | J at the start           | one more order of a series in a path parameter   |
/// | empirical_strategy       | none                     | f(X), interpolated at few states and times       |
/// | piecewise_linear_strategy| weighted J of points     | their weighted values                            |
/// | cross_strategy           | J(X) (Newton) or none    | f(X) - A X by cross interpolation                |
/// | enrichment_strategy      | J(X) as a sum of products| f(X) - A (X - x0); solved by enrichment          |
/// | decoupling_strategy      | none                     | f, one unknown after the other                   |
namespace samara::pgd {

/// X' = A X + b on a slab, rates per slab.
struct LinearSlab {
  /// A: row (m + n k) + n^2 i of the first mode is A(m, k) at Radau point i. Empty: none.
  std::optional<TensorTrain> jacobian = {};
  TensorTrain source;  ///< b: row m + n i
  /// Whether b is rounded more than the tolerance of the slab allows: such an iteration is never the last.
  bool rough = false;
};

/// Something that a strategy has approximated on its way to A and b.
struct StrategyDetail {
  std::string what;
  int rank = 0;
  double error = 0.0;  ///< largest at random entries that were not used
};

class Strategy {
 public:
  virtual ~Strategy() = default;
  virtual std::string name() const = 0;
  /// Called once before a march. @returns why there is no march, or nothing. @throws ArgumentError if the
  /// problem does not suit the strategy.
  virtual std::optional<Ending> prepare(const EvolutionProblem& problem, double tolerance) {
    (void)problem;
    (void)tolerance;
    return std::nullopt;
  }
  /// Called at the start of every slab. @returns why it cannot be solved, or nothing
  virtual std::optional<Ending> begin(const StrategySlab& slab) {
    (void)slab;
    return std::nullopt;
  }
  /// The linear problem whose solution is the next iterate. `correction`: of the iteration before, root mean
  /// square in scales; none before the first.
  virtual Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain& iterate,
                                        std::optional<double> correction) = 0;
  /// The solution of that problem, start included. By default in train algebra where there is no A, else from
  /// dense solves at the entries that a cross asks for. @param correction as above
  virtual Outcome<TensorTrain> solution(const StrategySlab& slab, const LinearSlab& linear,
                                        std::optional<double> correction, CrossPivots& pivots);
  /// Whether the iteration leads to the solution of the equations themselves.
  virtual bool is_exact() const { return true; }
  /// Iterations after which the strategy has nothing to add.
  virtual int max_iterations() const { return 1000; }
  /// Corrections may grow this many times in a row before the march calls the iteration divergent.
  virtual int patience() const { return 3; }
  /// Why corrections grow by `ratio`, as part of a sentence.
  virtual std::string on_divergence(double ratio) const;
  /// What the strategy has separated for itself on the last slab, or none.
  virtual std::optional<StrategyDetail> detail() const { return std::nullopt; }
  /// Evaluations made in prepare().
  virtual StrategyCounts prepared() const { return {}; }
};

/// IL, (6.26): f of the last iterate. A polynomial f by products of fields, compressed at once, any other by
/// cross interpolation. Contracts on short slabs only; the error falls factorially with the iterations.
std::unique_ptr<Strategy> incremental_strategy();

/// PL, (6.27): Taylor's expansion about one state.
struct PolynomialOptions {
  int order = 2;  ///< 1, or 2 with the quadratic term from the last iterate
  /// About which state, SI; empty: about the state at the start of each slab, at every parameter point.
  std::optional<Eigen::VectorXd> state = {};
};
/// The error is that of the expansion: of the power order + 1 of the distance to the state. Converges to the
/// solution of other equations; StrategyRecord::defect tells how far they are.
std::unique_ptr<Strategy> polynomial_strategy(const PolynomialOptions& options = {});

/// ANM, (6.28)-(6.29): X = X_0 + lambda X_1 + .. from the equations linearised about the start of the slab
/// (lambda = 0) to the full ones (lambda = 1). One linear solve per order, all with the same A; the Taylor
/// coefficients of the remainder from its values at Chebyshev nodes in lambda. Corrections are the terms of
/// the series: where they grow, its radius of convergence is below one, and the march says so.
std::unique_ptr<Strategy> asymptotic_strategy();

/// DEIM, (6.30): a basis over states and times is learned from f along the present iterate at training points
/// of the parameters; f is interpolated in it at greedily chosen rows, and the coefficients, functions of the
/// parameters, are separated by a cross that evaluates f at the times of these rows only. Retrained at points
/// where it is wrong, and in every iteration.
/// Reference: Chaturantabut and Sorensen, SIAM J. Sci. Comput. 32 (2010).
std::unique_ptr<Strategy> empirical_strategy();

/// PPWL, (6.31)-(6.32): a weighted sum of linearisations at points picked along a few training trajectories.
struct PiecewiseLinearOptions {
  int points = 100;
  int samples = 4;  ///< training states per Radau point and slab
  /// Of the separated weights, absolute. Zero: the tolerance of the slab.
  double weight_tolerance = 0.0;
};
/// f is taken affine in the parameters: exactly where the system is (EvolutionSystem::affine_in_parameters),
/// else by its slopes at the point's own parameters. Of limited accuracy by nature, on any motion.
std::unique_ptr<Strategy> piecewise_linear_strategy(const PiecewiseLinearOptions& options = {});

/// Newton or Picard with f (and J) of the iterate separated by cross interpolation over the parameters: any
/// f, any accuracy.
struct CrossStrategyOptions {
  bool newton = true;
};
std::unique_ptr<Strategy> cross_strategy(const CrossStrategyOptions& options = {});

/// Newton's iteration with every linear problem solved by enrichment (the dissertation's Algorithm 3): the
/// Jacobian and what is known are sums of products, and so is the correction of the state at the start. For
/// answers of few terms; where many are needed, enrichment finds them one by one, and trains are faster.
std::unique_ptr<Strategy> enrichment_strategy();

/// (6.17): every unknown has a field of its own, and its equation is solved by itself. What the others do to it
/// is a source of the last known fields: of this iteration for the unknowns before it, of the last one for those
/// after it (Gauss and Seidel). By products where f is a polynomial, else by a cross per unknown. A Picard
/// iteration, which contracts on short slabs or for weak coupling.
std::unique_ptr<Strategy> decoupling_strategy();

}  // namespace samara::pgd
