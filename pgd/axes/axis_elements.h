#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/axes/axis_tables.h"

/// Axes made of elements, continuous piecewise polynomials: p1, p2, chebyshev, legendre, radau; internal to
/// pgd/axes.
namespace samara::pgd {

/// Elements between `borders`. @param reference_nodes of one element on [-1, 1], both ends included
AxisTables element_tables(AxisLabel label, Basis basis, const Eigen::VectorXd& borders,
                          const Eigen::VectorXd& reference_nodes);

/// Borders of elements that are equal in s.
Eigen::VectorXd equal_elements(const AxisLabel& label, double lower, double upper, int elements);

/// Borders of panels of an element for Gauss's rule in s, ascending; its own without a transform. Integrals over
/// dx = (dx/ds) ds have the factor dx/ds, or ds/dx in the stiffness, which is no polynomial; in s it is entire or has
/// its pole at x = 0 or infinity. In panels over which x at most doubles, the pole is at least the panel's length
/// away in s, and each point more of the rule gains a factor (3 + sqrt 8)^2 = 34: twelve more than the polynomials
/// need are beyond rounding.
std::vector<double> panel_borders(Transform transform, double left, double right);

/// Element that holds x, the left one at a border; the first or last for points outside.
int element_of(const AxisTables& tables, double x);

void interpolate_element(const AxisTables& tables, double x, InterpolationStencil& stencil,
                         bool with_derivative);

}  // namespace samara::pgd
