#pragma once

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

/// Element that holds x, the left one at a border; the first or last for points outside.
int element_of(const AxisTables& tables, double x);

void interpolate_element(const AxisTables& tables, double x, InterpolationStencil& stencil,
                         bool with_derivative);

}  // namespace samara::pgd
