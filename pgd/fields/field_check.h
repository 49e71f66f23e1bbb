#pragma once

#include <span>
#include <string>
#include <vector>

#include "samara/pgd/fields/separated_field.h"

/// Checks shared by the functions of fields.
namespace samara::pgd {

/// Index of the axis of that name. @throws ArgumentError with a suggestion if there is none.
int axis_index(const std::vector<Axis>& axes, const std::string& name);
/// @throws ArgumentError naming the first difference if the fields do not lie on the same axes.
void require_same_axes(const char* what, const std::vector<Axis>& a, const std::vector<Axis>& b);
/// @throws ArgumentError if outputs differ in number or unit.
void require_same_outputs(const char* what, const std::vector<OutputLabel>& f,
                          const std::vector<OutputLabel>& g);
/// @throws ArgumentError if there is one axis only, which therefore cannot go.
void require_another_axis(const std::vector<Axis>& axes);
/// @throws ArgumentError if x is not finite; OutsideBoxError if it is outside the axis.
void require_on_axis(const Axis& axis, double x);
/// @throws ArgumentError if x has not one finite number per axis; OutsideBoxError if one is outside its axis,
/// or between the values of a discrete one.
void require_inside(const std::vector<Axis>& axes, std::span<const double> x);

}  // namespace samara::pgd
