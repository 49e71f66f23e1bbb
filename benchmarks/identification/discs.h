#pragma once

#include "real_data.h"

/// What fits of falling discs, seen as positions alone, have in common.
namespace samara::benchmarks::identification {

/// Start states of `immersed_body` that a fit may reach, all but the spin about the axis.
/// @param place m @param speed m/s @param rate rad/s, in every direction
Box disc_start_box(double place, double speed, double rate);

/// Coefficients from windows, their logarithms known to within a factor of e, errors between motions.
/// @param first guesses of the coefficients
/// @param misfit m, beyond which residuals count less
/// @param motion the label that names it
samara::identification::FitOptions disc_options(const Coefficients& first, double misfit,
                                                const std::string& motion);

}  // namespace samara::benchmarks::identification
