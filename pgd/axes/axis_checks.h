#pragma once

#include <string>

#include <Eigen/Core>

#include "samara/pgd/axes/axis_tables.h"

/// What the factories of all kinds of axes ask of their arguments; internal to pgd/.
namespace samara::pgd {

/// The axis of that name, for a message.
std::string axis_text(const AxisLabel& label);

/// @throws ArgumentError unless there are at least `least` values, all finite and increasing.
void check_increasing(const AxisLabel& label, const Eigen::VectorXd& values, int least);

/// @throws ArgumentError if the label has a transform, which the named kind of axis cannot have.
void check_no_transform(const AxisLabel& label, const char* kind);

}  // namespace samara::pgd
