#pragma once

#include <functional>

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"

/// Weak forms on one axis with a coefficient, by Gauss quadrature on every element: what operators and
/// sources are put together from. N_i: the axis's basis; the coefficient f is a function of the coordinate
/// or, in the second form, given by its values at the nodes. Exact for polynomial coefficients of up to the
/// axis's degree. O(nodes degree^2).
/// @throws ArgumentError if the axis has no elements (periodic, discrete or imported ones), nodal values do
/// not match it, f is not finite somewhere, or the axis has no stiffness (a square root from 0).
namespace samara::pgd {

using AxisFunction = std::function<double(double)>;

/// Integral of f N_i N_j.
SparseMatrix weighted_mass(const Axis& axis, const AxisFunction& f);
SparseMatrix weighted_mass(const Axis& axis, const Eigen::VectorXd& nodal_values);
/// Integral of f N_i dN_j/dx.
SparseMatrix weighted_gradient(const Axis& axis, const AxisFunction& f);
SparseMatrix weighted_gradient(const Axis& axis, const Eigen::VectorXd& nodal_values);
/// Integral of f dN_i/dx dN_j/dx.
SparseMatrix weighted_stiffness(const Axis& axis, const AxisFunction& f);
SparseMatrix weighted_stiffness(const Axis& axis, const Eigen::VectorXd& nodal_values);

/// Integral of f N_i.
Eigen::VectorXd load_vector(const Axis& axis, const AxisFunction& f);
/// N_i(x): the load of a unit point source.
Eigen::VectorXd point_load(const Axis& axis, double x);

/// f at the nodes.
Eigen::VectorXd nodal_values(const Axis& axis, const AxisFunction& f);
/// The interpolated function of nodal values.
AxisFunction interpolated(const Axis& axis, const Eigen::VectorXd& nodal_values);

}  // namespace samara::pgd
