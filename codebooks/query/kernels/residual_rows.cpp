#include "samara/codebooks/query/kernels/residual_rows.h"

#include <utility>

#include "samara/codebooks/query/kernels/vectors.h"

namespace samara::codebooks::kernels {

namespace {

/// Vector kOut of a row-major matrix, from vectors of its first kUsed columns; lanes of others are left over.
template <int kColumns, int kUsed, int kOut, int... kLane>
[[gnu::always_inline]] inline Vector<double> interleaved(const Vector<double>* column,
                                                         std::integer_sequence<int, kLane...> lanes) {
  constexpr int kLength = sizeof...(kLane), kFirst = kOut * kLength;
  if constexpr (kUsed == 2) {
    return __builtin_shufflevector(
        column[0], column[1],
        ((kFirst + kLane) % kColumns == 1 ? kLength : 0) + (kFirst + kLane) / kColumns...);
  } else {
    return __builtin_shufflevector(
        interleaved<kColumns, kUsed - 1, kOut>(column, lanes), column[kUsed - 1],
        ((kFirst + kLane) % kColumns == kUsed - 1 ? kLength + (kFirst + kLane) / kColumns : kLane)...);
  }
}

template <int kColumns>
void residual_columns(const double* values, const double* slopes, const double* observed,
                      const double* scales, std::ptrdiff_t rows, double* residuals, double* jacobian) {
  constexpr int kLength = kWidth<double>;
  std::ptrdiff_t i = 0;
  for (; i + kLength <= rows; i += kLength) {
    const Vector<double> weight = 1.0 / load(scales + i);
    store<double>((load(values + i) - load(observed + i)) * weight, residuals + i);
    Vector<double> column[kColumns];
#pragma GCC unroll 8
    for (int k = 0; k < kColumns; ++k) column[k] = load(slopes + i + rows * k) * weight;
    double* const to = jacobian + i * kColumns;
    [&]<int... kOut>(std::integer_sequence<int, kOut...>) {
      const std::make_integer_sequence<int, kLength> lanes;
      (store<double>(interleaved<kColumns, kColumns, kOut>(column, lanes), to + kOut * kLength), ...);
    }
    (std::make_integer_sequence<int, kColumns>());
  }
  for (; i < rows; ++i) {
    const double weight = 1.0 / scales[i];
    residuals[i] = (values[i] - observed[i]) * weight;
    for (int k = 0; k < kColumns; ++k) jacobian[i * kColumns + k] = slopes[i + rows * k] * weight;
  }
}

}  // namespace

void residual_rows(const double* values, const double* slopes, const double* observed, const double* scales,
                   std::ptrdiff_t rows, int columns, double* residuals, double* jacobian) {
  if (jacobian != nullptr) {
    const auto run = [&](auto count) {
      residual_columns<count()>(values, slopes, observed, scales, rows, residuals, jacobian);
    };
    if (columns == 2) return run(std::integral_constant<int, 2>());
    if (columns == 3) return run(std::integral_constant<int, 3>());
    if (columns == 4) return run(std::integral_constant<int, 4>());
  }
  for (std::ptrdiff_t i = 0; i < rows; ++i) {
    const double weight = 1.0 / scales[i];
    residuals[i] = (values[i] - observed[i]) * weight;
    for (int k = 0; jacobian != nullptr && k < columns; ++k)
      jacobian[i * columns + k] = slopes[i + rows * k] * weight;
  }
}

}  // namespace samara::codebooks::kernels
