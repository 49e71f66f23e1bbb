#pragma once

#include <string>

#include "samara/pgd/fields/train_field.h"

/// The algebra of field_algebra.h for trains: exact for the represented functions up to round-off, and with
/// the same errors. Costs for ranks r, d axes of n nodes.
namespace samara::pgd {

/// f + scale_g * g, of ranks r + r': rounded() to a tolerance should follow. O(d n (r + r')^2).
TrainField sum(const TrainField& f, const TrainField& g, double scale_g = 1.0);
/// factor * f. The factor has no unit.
TrainField scaled(const TrainField& f, double factor);
/// f at one coordinate of an axis, which goes. O(n r^2).
/// @throws ArgumentError also if it is the only axis (evaluate the field instead) or x is not finite;
/// OutsideBoxError if x is outside the axis.
TrainField restricted(const TrainField& f, const std::string& axis, double x);
/// Integral over an axis, which goes; units are multiplied by the axis'. O(n r^2).
/// @throws ArgumentError also if it is the only axis.
TrainField integral(const TrainField& f, const std::string& axis);
/// Mean over an axis (its integral divided by its measure), which goes. O(n r^2).
TrainField mean(const TrainField& f, const std::string& axis);
/// Derivative by the coordinate of an axis, as of separated fields. Units are divided by the axis'. O(n p r^2)
/// for p nodes per element.
TrainField derivative(const TrainField& f, const std::string& axis);

}  // namespace samara::pgd
