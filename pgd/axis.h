#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "samara/pgd/lagrange.h"

namespace samara::pgd {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// How functions of one coordinate are represented.
enum class Basis {
  p1,         ///< continuous piecewise linear finite elements on any mesh; order 2
  chebyshev,  ///< one polynomial through the Chebyshev-Lobatto points; converges geometrically
  radau,  ///< time elements: degree s through the start of the element and its s right Radau points; order s
          ///< + 1 between the nodes, 2s - 1 at the ends of the elements when used for collocation
};

enum class AxisRole { time, space, parameter, initial, boundary };

/// Weights of the nodes that a point touches: u(x) = sum_j value[j] u[first + j], likewise for du/dx.
struct InterpolationStencil {
  int first = 0;
  Eigen::VectorXd value;
  Eigen::VectorXd derivative;
};

/// One coordinate: its interval and its discretisation. A continuous, piecewise polynomial nodal basis; all
/// kinds are elements with the same reference nodes, both ends of an element included and shared with its
/// neighbours.
///
/// Coordinates and matrices are in the unit of the axis; inside, every element is mapped to [-1, 1].
/// Cheap to copy: the tables are shared and immutable.
class Axis {
 public:
  struct Label {
    std::string name;
    std::string unit = "1";
    AxisRole role = AxisRole::parameter;
  };

  /// Finite elements on the mesh `nodes` (strictly increasing, at least two).
  /// @throws ArgumentError if nodes are not finite or not increasing. The same for all factories.
  static Axis p1(Label label, const Eigen::VectorXd& nodes);
  /// Finite elements on `count` equidistant nodes of [lower, upper].
  static Axis p1(Label label, double lower, double upper, int count);
  /// `count` >= 2 Chebyshev-Lobatto points of [lower, upper].
  static Axis chebyshev(Label label, double lower, double upper, int count);
  /// Collocation elements of degree `points` >= 1 between the given borders.
  static Axis radau(Label label, const Eigen::VectorXd& borders, int points);
  /// The same with `elements` equal elements.
  static Axis radau(Label label, double lower, double upper, int elements, int points);

  const std::string& name() const { return tables_->label.name; }
  const std::string& unit() const { return tables_->label.unit; }
  AxisRole role() const { return tables_->label.role; }
  Basis basis() const { return tables_->basis; }
  double lower() const { return tables_->borders[0]; }
  double upper() const { return tables_->borders[tables_->borders.size() - 1]; }
  double length() const { return upper() - lower(); }
  int size() const { return static_cast<int>(tables_->nodes.size()); }
  const Eigen::VectorXd& nodes() const { return tables_->nodes; }

  /// Borders of the elements, ascending.
  const Eigen::VectorXd& borders() const { return tables_->borders; }
  int elements() const { return static_cast<int>(tables_->borders.size()) - 1; }
  /// Polynomial degree in each element.
  int degree() const { return tables_->local.size() - 1; }
  /// The basis on one element, mapped to [-1, 1].
  const LagrangeBasis& element_basis() const { return tables_->local; }

  /// M_ij = integral of N_i N_j.
  const SparseMatrix& mass() const { return tables_->mass; }
  /// G_ij = integral of N_i dN_j/dx, the weak form of the derivative (row: test function).
  const SparseMatrix& gradient() const { return tables_->gradient; }
  /// K_ij = integral of dN_i/dx dN_j/dx.
  const SparseMatrix& stiffness() const { return tables_->stiffness; }
  /// w_i = integral of N_i: quadrature weights on the nodes.
  const Eigen::VectorXd& weights() const { return tables_->weights; }
  /// D_ij = dN_j/dx at node i. At the border of two elements the derivative of the left one: with it, row i
  /// of D u = f is the collocation condition of the radau kind.
  const SparseMatrix& derivative() const { return tables_->derivative; }

  /// Nodes touched by one point.
  int stencil_size() const { return tables_->local.size(); }
  /// A stencil of the right size.
  InterpolationStencil make_stencil() const;
  /// Interpolation weights at x and, if asked for, their derivatives by x (at a border, of the left element).
  /// x is taken as given: outside the interval this extrapolates. Does not allocate.
  void interpolate(double x, InterpolationStencil& stencil, bool with_derivative) const;
  /// Element that holds x (the left one at a border); the first or last for points outside.
  int element_of(double x) const;

  /// True if the interval contains x, borders included.
  bool contains(double x) const { return x >= lower() && x <= upper(); }

 private:
  struct Tables {
    Label label;
    Basis basis = Basis::p1;
    Eigen::VectorXd borders;
    LagrangeBasis local;
    Eigen::VectorXd nodes;
    Eigen::VectorXd weights;
    SparseMatrix mass, gradient, stiffness, derivative;
  };
  static Axis make(Label label, Basis basis, const Eigen::VectorXd& borders,
                   const Eigen::VectorXd& reference_nodes);
  explicit Axis(std::shared_ptr<const Tables> tables) : tables_(std::move(tables)) {}

  std::shared_ptr<const Tables> tables_;
};

/// The names used in files: "p1", "chebyshev", "radau" and "time", "space", "parameter", "initial",
/// "boundary".
std::string to_string(Basis basis);
std::string to_string(AxisRole role);
/// @throws ArgumentError for an unknown name.
Basis basis_from_string(const std::string& name);
AxisRole role_from_string(const std::string& name);

}  // namespace samara::pgd
