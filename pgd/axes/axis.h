#pragma once

#include <memory>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "samara/pgd/axes/axis_tables.h"

namespace samara::pgd {

/// One coordinate: its interval and its discretisation by a nodal basis N_i with N_i(node j) = 1 if i = j,
/// else 0. There are three families (basis.h):
///
///  - elements (p1, p2, chebyshev, legendre, radau): continuous piecewise polynomials; every element has the
///    same reference nodes, both ends included and shared with its neighbours. They are polynomials in
///    s = T(x) if the label has a transform;
///  - fourier: every basis function covers the whole period [lower, upper];
///  - lists (discrete, imported): functions at the nodes only, without derivatives.
///
/// Coordinates, nodes and matrices are in the unit of the axis, and integrals are over dx, also under a
/// transform; inside, every element is mapped to [-1, 1]. Integrals are exact to rounding.
/// Cheap to copy: the tables are shared and immutable.
class Axis {
 public:
  using Label = AxisLabel;

  /// Finite elements on the mesh `nodes` (strictly increasing, at least two).
  /// @throws ArgumentError if nodes are not finite or not increasing, if they leave the domain of the
  /// transform, or if the kind has no elements to transform. The same for all factories.
  static Axis p1(Label label, const Eigen::VectorXd& nodes);
  /// Finite elements on `count` nodes of [lower, upper], equidistant in s.
  static Axis p1(Label label, double lower, double upper, int count);
  /// Quadratic elements between the given borders; their third nodes are in the middle (of s).
  static Axis p2(Label label, const Eigen::VectorXd& borders);
  /// The same with `elements` elements, equal in s: 2 elements + 1 nodes.
  static Axis p2(Label label, double lower, double upper, int elements);
  /// `count` >= 2 Chebyshev-Lobatto points of [lower, upper].
  static Axis chebyshev(Label label, double lower, double upper, int count);
  /// Elements of degree `degree` >= 1 between the given borders.
  static Axis chebyshev(Label label, const Eigen::VectorXd& borders, int degree);
  /// `count` >= 2 Gauss-Legendre-Lobatto points of [lower, upper].
  static Axis legendre(Label label, double lower, double upper, int count);
  /// Elements of degree `degree` >= 1 between the given borders.
  static Axis legendre(Label label, const Eigen::VectorXd& borders, int degree);
  /// Elements of a basis that has them, of degree `degree` >= 1 (p1 and p2 have their own), between the given
  /// borders. @throws ArgumentError also if the basis has no elements.
  static Axis of_elements(Label label, Basis basis, const Eigen::VectorXd& borders, int degree);
  /// Collocation elements of degree `points` >= 1 between the given borders.
  static Axis radau(Label label, const Eigen::VectorXd& borders, int points);
  /// The same with `elements` elements, equal in s.
  static Axis radau(Label label, double lower, double upper, int elements, int points);
  /// Functions of period upper - lower: `count` = 2m + 1 >= 3 equidistant nodes, lower among them and upper
  /// not; the trigonometric polynomials of degree m.
  /// @throws ArgumentError also if count is even: the highest cosine would be without its sine.
  static Axis fourier(Label label, double lower, double upper, int count);
  /// A list of increasing values, at least one. The mass is the identity, the weights are one.
  static Axis discrete(Label label, const Eigen::VectorXd& values);
  /// Nodes 0, 1, .., n - 1 of a discretisation with the given symmetric positive definite mass matrix; the
  /// weights are its row sums, which is right where the basis functions sum to one.
  /// @throws ArgumentError if the matrix is empty, not square, not symmetric to 1e-12 of its diagonal, not
  /// finite, or has an entry that no positive definite matrix has (m_ii <= 0 or m_ij^2 >= m_ii m_jj).
  /// Definite as a whole it is the caller's to grant: a factorisation may cost more than all else.
  static Axis imported(Label label, const SparseMatrix& mass);

  const std::string& name() const { return tables_->label.name; }
  const std::string& unit() const { return tables_->label.unit; }
  AxisRole role() const { return tables_->label.role; }
  Transform transform() const { return tables_->label.transform; }
  Basis basis() const { return tables_->basis; }
  AxisFamily family() const { return tables_->family; }
  /// Whether there are values at the nodes only.
  bool is_list() const { return family() == AxisFamily::list; }
  /// Ends of the interval: of the period if periodic, else the first and last node.
  double lower() const { return tables_->lower; }
  double upper() const { return tables_->upper; }
  double length() const { return upper() - lower(); }
  /// Integral of 1: the length of the interval, or for lists the sum of the mass matrix.
  double measure() const { return tables_->measure; }
  int size() const { return static_cast<int>(tables_->nodes.size()); }
  /// Ascending.
  const Eigen::VectorXd& nodes() const { return tables_->nodes; }

  /// Whether the basis is made of elements: all kinds but fourier and the lists.
  bool has_elements() const { return tables_->local.has_value(); }
  /// Borders of the elements, ascending; empty without elements.
  const Eigen::VectorXd& borders() const { return tables_->borders; }
  /// 0 without elements.
  int elements() const { return has_elements() ? static_cast<int>(tables_->borders.size()) - 1 : 0; }
  /// Polynomial degree in each element. @throws ArgumentError without elements.
  int degree() const { return element_basis().size() - 1; }
  /// The basis on one element, mapped to [-1, 1]. @throws ArgumentError without elements.
  const LagrangeBasis& element_basis() const;

  /// M_ij = integral of N_i N_j.
  const SparseMatrix& mass() const { return tables_->mass; }
  /// G_ij = integral of N_i dN_j/dx, the weak form of the derivative (row: test function).
  /// @throws ArgumentError for lists. The same for the next two, which also do not exist for square_root from
  /// 0, where derivatives are infinite.
  const SparseMatrix& gradient() const { return existing(tables_->gradient, "gradient"); }
  /// K_ij = integral of dN_i/dx dN_j/dx.
  const SparseMatrix& stiffness() const { return existing(tables_->stiffness, "stiffness"); }
  /// w_i = integral of N_i: quadrature weights on the nodes.
  const Eigen::VectorXd& weights() const { return tables_->weights; }
  /// D_ij = dN_j/dx at node i. At the border of two elements the derivative of the left one: with it, row i
  /// of D u = f is the collocation condition of the radau kind.
  const SparseMatrix& derivative() const { return existing(tables_->derivative, "derivative"); }

  /// Nodes touched by one point.
  int stencil_size() const;
  /// A stencil of the right size.
  InterpolationStencil make_stencil() const;
  /// Interpolation weights at x and, if asked for, their derivatives by x (at a border, of the left element).
  /// Does not allocate. Points outside: elements extrapolate (NaN outside the domain of the transform),
  /// fourier goes on periodically, lists take the nearest node, the lower one of two.
  /// Derivatives are NaN on lists, and not finite at x = 0 under square_root.
  void interpolate(double x, InterpolationStencil& stencil, bool with_derivative) const;
  /// Element that holds x (the left one at a border); the first or last for points outside; 0 without
  /// elements.
  int element_of(double x) const;

  /// True if the interval contains x, borders included; on lists, if x is exactly one of the nodes.
  bool contains(double x) const;

 private:
  explicit Axis(AxisTables tables);

  const SparseMatrix& existing(const std::optional<SparseMatrix>& matrix, const char* what) const;

  std::shared_ptr<const AxisTables> tables_;
};

}  // namespace samara::pgd
