#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/fields/separated_field.h"

/// Parametric evolution equations,
///
///   x' = f(t, x, q),  x(0) = x0(q),   t on a time axis, q on parameter axes,
///
/// as marches and their strategies are given them: f and df/dx at batches of points, and nothing else.
namespace samara::pgd {

class PolynomialSystem;

/// What the engine must know of the equations. Implementations are asked from many threads at once.
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

}  // namespace samara::pgd
