#pragma once

#include <cstddef>

/// Compiled for the machine, as kernels.h.
namespace samara::codebooks::kernels {

/// What a fit asks for: residuals[i] = (values[i] - observed[i]) / scales[i], and their derivatives row by
/// row, jacobian[i * columns + k] = slopes[i + rows * k] / scales[i]. No buffer needs more than its numbers.
/// @param jacobian null: not wanted
void residual_rows(const double* values, const double* slopes, const double* observed, const double* scales,
                   std::ptrdiff_t rows, int columns, double* residuals, double* jacobian);

}  // namespace samara::codebooks::kernels
