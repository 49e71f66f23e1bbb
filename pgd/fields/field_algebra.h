#pragma once

#include <string>

#include <Eigen/Core>

#include "samara/pgd/fields/separated_field.h"

/// Algebra of separated fields that needs factors only, exact for the represented functions up to round-off
/// (the derivative as stated). Products and other functions of fields: field_functions.h; mean and variance
/// over several axes: statistics.h.
///
/// Costs for rank R, axes of n nodes, d axes, M outputs. All functions throw ArgumentError naming the axis or
/// output: if two fields do not lie on the same axes (name, unit, basis, transform, nodes and mass,
/// in order), if their outputs do not match in number and unit, or if no axis has a name (the nearest is
/// suggested). Outputs of two fields are paired in order; the names are those of the first field.
namespace samara::pgd {

/// Index of the axis of that name. @throws ArgumentError if there is none.
int axis_index(const SeparatedField& field, const std::string& axis);

/// Nodal values as a tensor with the modes (outputs, axes..). O(R (M + d n)).
SeparatedTensor nodal_values(const SeparatedField& field);
/// The field with these nodal values.
/// @throws ArgumentError if the tensor is not outputs x nodes of the axes.
SeparatedField field_from_nodal_values(std::vector<Axis> axes, std::vector<OutputLabel> outputs,
                                       const SeparatedTensor& values);

/// f + scale_g * g, of rank R + R'. O((R + R') (M + d n)).
SeparatedField sum(const SeparatedField& f, const SeparatedField& g, double scale_g = 1.0);
/// factor * f. The factor has no unit.
SeparatedField scaled(const SeparatedField& f, double factor);

/// Per output the integral of f_m g_m over the box, exact, in the square of the output's unit times the units
/// of the axes. O(R R' (d n + M)).
Eigen::VectorXd l2_inner(const SeparatedField& f, const SeparatedField& g);
/// Per output the root of the integral of f_m^2 over the box: eight digits or better also where terms cancel.
/// O(M R^2 d n), where they cancel O(M d n R^3).
Eigen::VectorXd l2_norm(const SeparatedField& f);
/// The same divided by the root of the box's volume: the root mean square, in the unit of the output.
Eigen::VectorXd root_mean_square(const SeparatedField& f);

/// f at one coordinate of an axis, which goes. O(R n).
/// @throws ArgumentError also if it is the only axis (evaluate the field instead) or x is not finite;
/// OutsideBoxError if x is outside the axis.
SeparatedField restricted(const SeparatedField& f, const std::string& axis, double x);
/// Integral over an axis, which goes; units are multiplied by the axis'. O(R n).
/// @throws ArgumentError also if it is the only axis.
SeparatedField integral(const SeparatedField& f, const std::string& axis);
/// Mean over an axis (its integral divided by its measure), which goes. O(R n).
SeparatedField mean(const SeparatedField& f, const std::string& axis);
/// Derivative by the coordinate of an axis: interpolates the exact derivative at the nodes, at the border of
/// two elements that of the left one. Exact for Chebyshev axes; of one order less than the field for
/// elements. Units are divided by the axis'. O(R n p) for p nodes per element.
SeparatedField derivative(const SeparatedField& f, const std::string& axis);

struct FieldCompression {
  SeparatedField field;
  Eigen::VectorXd error;       ///< per output: ||field - f|| / ||f|| in L2 over the box, measured
  bool tolerance_met = false;  ///< error <= tolerance for all outputs
};

/// The same field with fewer terms, every output within `tolerance` of its own L2 norm over the box. See
/// compress() in compression.h for method and cost.
/// @throws ArgumentError if the tolerance is not positive.
FieldCompression compress(const SeparatedField& f, double tolerance);

}  // namespace samara::pgd
