#pragma once

#include <map>
#include <string>
#include <vector>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/linear/linear_problem.h"

namespace samara::pgd {

/// A linear problem put together term by term over named axes, with known values (boundary and initial data)
/// taken care of.
///
/// On *weak* axes (space) equations are tested with the basis functions; the parts of operators are matrices
/// such as Axis::stiffness() and those of axis_forms.h. On *nodal* axes (time, parameters, initial and
/// boundary values) equations hold at the nodes; parts are Axis::derivative() or diagonals of nodal values,
/// and the equations are weighed by the axis's quadrature weights. A term or source that does not name an
/// axis does not depend on it: mass() or weights() stand there on weak axes, the identity or ones on nodal
/// ones.
///
/// Dirichlet and initial data: `know(axis, nodes)` marks nodes of an axis at which the solution is that of
/// the lift, a separated tensor on the whole grid; with the data themselves as coordinates of the lift they
/// become axes. Neumann data are sources, Robin data sources and terms, both with point_load() on the border.
///
///   ParametricProblem heat({x, k});
///   heat.add_term({{"x", ModeOperator::sparse(x.stiffness())}, {"k", ModeOperator::diagonal(k.nodes())}});
///   heat.add_source({});
///   heat.know("x", {0, x.size() - 1});
///   SeparatedTensor u = heat.complete(enrich(heat.assemble()).solution);
class ParametricProblem {
 public:
  /// Axes of the role space are weak, the others nodal.
  /// @throws ArgumentError if there is none, or two have one name.
  explicit ParametricProblem(std::vector<Axis> axes);

  const std::vector<Axis>& axes() const { return axes_; }
  // What was added: parts on all axes, and nodal values of sources and lift, known nodes included.
  const SeparatedOperator& terms() const { return op_; }
  const SeparatedTensor& source() const { return rhs_; }
  const SeparatedTensor& lift() const { return lift_; }

  /// Adds scale * the product of the given parts to the operator.
  /// @throws ArgumentError for an unknown axis, a part of another size, or an entry that is not finite. The
  /// same for all that follow.
  void add_term(const std::map<std::string, ModeOperator>& parts, double scale = 1.0);
  /// Adds scale * the product of the given vectors to the right-hand side: load vectors on weak axes, nodal
  /// values on nodal ones.
  void add_source(const std::map<std::string, Eigen::VectorXd>& parts, double scale = 1.0);
  /// The equations at these nodes are replaced by known values, those of the lift (zero without one).
  void know(const std::string& axis, std::vector<int> nodes);
  /// Measures the residual on a weak axis in the dual norm of this symmetric positive matrix on all nodes
  /// (LinearProblem::row_norms), such as the stiffness: known nodes leave it as they leave the equations.
  void measure(const std::string& axis, const SparseMatrix& norm);
  /// Adds scale * a product of nodal values to the lift; axes that are not named: ones.
  void add_to_lift(const std::map<std::string, Eigen::VectorXd>& values, double scale = 1.0);

  /// The problem at one point of some nodal axes, over the others: what stands on those axes counts by its
  /// interpolated value there.
  /// @param point a coordinate by the name of its axis, inside
  /// @throws ArgumentError for an unknown or a weak axis, one with known nodes, a coordinate outside, or an
  /// operator on such an axis that is no diagonal; and if no axis is left.
  ParametricProblem at(const std::map<std::string, double>& point) const;
  /// Nodes of an axis that are not known, ascending. @throws ArgumentError for an unknown axis, or if all are known
  std::vector<int> unknown_nodes(const std::string& axis) const { return unknown_nodes(position(axis)); }

  /// The equations of what is left of the solution, without the known nodes: D (U - lift) = G - D lift.
  /// @throws ArgumentError if there is no term, or all nodes of an axis are known.
  LinearProblem assemble() const;
  /// The solution on the whole grid: that of assemble(), zero at the known nodes, and the lift.
  SeparatedTensor complete(const SeparatedTensor& unknown) const;

 private:
  std::size_t position(const std::string& axis) const;
  bool is_weak(std::size_t k) const { return axes_[k].role() == AxisRole::space; }
  /// Nodes of the axis that are not known, ascending.
  std::vector<int> unknown_nodes(std::size_t k) const;
  /// Of all nodes of a nodal axis.
  Eigen::VectorXd interpolation_weights(std::size_t k, double x) const;

  std::vector<Axis> axes_;
  SeparatedOperator op_;
  SeparatedTensor rhs_;
  SeparatedTensor lift_;
  std::vector<std::vector<int>> known_;
  std::vector<SparseMatrix> norms_;  ///< empty: none
};

}  // namespace samara::pgd
