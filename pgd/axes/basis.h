#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace samara::pgd {

class Axis;
struct AxisLabel;

/// How functions of one coordinate are represented. What is known of each stands in one table, basis_traits().
enum class Basis {
  p1,         ///< continuous piecewise linear finite elements on any mesh; order 2
  chebyshev,  ///< elements through their Chebyshev-Lobatto points; one element converges geometrically
  /// Time elements: degree s through the start of the element and its s right Radau points; order s + 1 between the
  /// nodes, 2s - 1 at the ends of the elements when used for collocation.
  radau,
  p2,        ///< continuous piecewise quadratic finite elements on any mesh; order 3
  legendre,  ///< elements through their Gauss-Legendre-Lobatto points; one element converges geometrically
  fourier,   ///< trigonometric polynomials of one period on equidistant nodes; converges geometrically
  discrete,  ///< a list of values, each counting one; nothing between them
  imported,  ///< nodes of somebody else's discretisation, known by its mass matrix only
};

/// How a basis interpolates.
enum class AxisFamily {
  elements,  ///< by the polynomial of the element that holds the point; intervals can be split, transformed
  periodic,  ///< by all nodes, over one period
  list,      ///< not at all: there are values at the nodes only, and no derivatives
};

/// One row per basis. A new basis is a new row, a factory of Axis, and where it belongs to none of the families, its
/// tables and its interpolation: axis.cpp here, in codebooks file/piece_format.cpp and query/kernels/axis_weights.cpp.
struct BasisTraits {
  Basis basis;
  const char* name;  ///< in files and plans
  AxisFamily family;
  bool storable;  ///< whether name, interval, elements and nodes, which is what a file holds, say all
  /// Whether the highest coefficients of a function say if there are nodes enough, so that their number may be
  /// chosen by a build.
  bool tells_resolution;
  bool odd_nodes;  ///< whether the number of nodes over an interval is odd
  /// Nodes of an element on [-1, 1]. @param degree of the element; p1 and p2 have their own. Null without
  /// elements.
  Eigen::VectorXd (*element_nodes)(int degree);
  /// An axis of `nodes` nodes over an interval. Null for what does not discretise a parameter.
  Axis (*over_interval)(AxisLabel label, double lower, double upper, int nodes);

  bool discretises_parameters() const { return over_interval != nullptr; }
  /// Whether the functions over a part of the interval are of the same kind.
  bool can_be_split() const { return family == AxisFamily::elements; }
};

const BasisTraits& basis_traits(Basis basis);

/// Of the bases that discretise a parameter: first those whose number of nodes a build can choose.
std::vector<std::string> parameter_basis_names();

/// The names used in files: "p1", "chebyshev", "radau", "p2", "legendre", "fourier", "discrete", "imported".
std::string to_string(Basis basis);
/// @throws ArgumentError for an unknown name.
Basis basis_from_string(const std::string& name);

}  // namespace samara::pgd
