#pragma once

#include "samara/pgd/axes/axis_tables.h"

/// The periodic kind of axis; internal to pgd/axes.
namespace samara::pgd {

/// `count` = 2m + 1 >= 3 equidistant nodes of one period.
AxisTables fourier_tables(AxisLabel label, double lower, double upper, int count);

void interpolate_fourier(const AxisTables& tables, double x, InterpolationStencil& stencil,
                         bool with_derivative);

}  // namespace samara::pgd
