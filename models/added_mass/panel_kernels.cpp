#include "samara/models/added_mass/panel_kernels.h"

#include <cmath>

// GCC compiles these once more for processors with 256-bit registers and chooses when the library is loaded.
// Not under sanitizers, whose start-up comes after that choice.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define SAMARA_WIDE __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define SAMARA_WIDE
#endif

namespace samara::models::added_mass {

SAMARA_WIDE void far_sources(const FarPanel* panels, std::size_t n, const LanePoints& points, double* source,
                             double* r2) {
  for (std::size_t j = 0; j < n; ++j) {
    const FarPanel& p = panels[j];
    for (std::size_t i = 0; i < kLanes; ++i) {
      const double x = points.x[0][i] - p.centroid[0];
      const double y = points.x[1][i] - p.centroid[1];
      const double z = points.x[2][i] - p.centroid[2];
      // The sum of both panels' moments: r of two points is that of the centroids plus a difference.
      const double xx = points.moment[0][i] + p.moment[0];
      const double yy = points.moment[1][i] + p.moment[1];
      const double zz = points.moment[2][i] + p.moment[2];
      const double xy = points.moment[3][i] + p.moment[3];
      const double yz = points.moment[4][i] + p.moment[4];
      const double zx = points.moment[5][i] + p.moment[5];
      const double square = x * x + y * y + z * z;
      const double inverse = 1.0 / square;
      const double along = x * (xx * x + 2.0 * (xy * y + zx * z)) + y * (yy * y + 2.0 * yz * z) + z * z * zz;
      const double second = 0.5 * inverse * (3.0 * inverse * along - (xx + yy + zz));
      source[j * kLanes + i] = p.area_over_4pi * std::sqrt(inverse) * (1.0 + second);
      r2[j * kLanes + i] = square;
    }
  }
}

SAMARA_WIDE void far_dipoles(const FarPanel* panels, std::size_t n, const LanePoints& points,
                             double* dipole) {
  for (std::size_t j = 0; j < n; ++j) {
    const FarPanel& p = panels[j];
    for (std::size_t i = 0; i < kLanes; ++i) {
      const double x = points.x[0][i] - p.centroid[0];
      const double y = points.x[1][i] - p.centroid[1];
      const double z = points.x[2][i] - p.centroid[2];
      const double inverse = 1.0 / (x * x + y * y + z * z);
      const double height = x * p.normal[0] + y * p.normal[1] + z * p.normal[2];
      dipole[j * kLanes + i] = p.area_over_4pi * height * inverse * std::sqrt(inverse);
    }
  }
}

SAMARA_WIDE void add_outer(const double* in, const double* factor, std::size_t rows, double* const* out) {
  for (std::size_t r = 0; r < rows; ++r) {
    double* to = out[r];
    const double f = factor[r];
    for (std::size_t i = 0; i < kLanes; ++i) to[i] += f * in[i];
  }
}

namespace {

/// Four numbers in one or two registers (an extension of GCC and Clang): left to itself GCC keeps the sums in
/// memory.
using Four = double __attribute__((vector_size(32), aligned(8)));

}  // namespace

SAMARA_WIDE void multiply_rows(const double* A, std::size_t n, std::size_t first, std::size_t last,
                               const double* x, double* y) {
  // Four rows at a time, so that each entry of x is loaded once for them; a last few rows are done twice.
  constexpr std::size_t kRows = 4;
  for (std::size_t start = first; start < last; start += kRows) {
    const std::size_t count = last - start < kRows ? last - start : kRows;
    const double* row[kRows];
    for (std::size_t r = 0; r < kRows; ++r) row[r] = A + (start + (r < count ? r : 0)) * n;
    Four low[kRows] = {}, high[kRows] = {};
    for (std::size_t b = 0; b < n; ++b) {
      const Four* x_b = reinterpret_cast<const Four*>(x + b * kColumns);
      for (std::size_t r = 0; r < kRows; ++r) {
        low[r] += row[r][b] * x_b[0];
        high[r] += row[r][b] * x_b[1];
      }
    }
    for (std::size_t r = 0; r < count; ++r) {
      Four* y_r = reinterpret_cast<Four*>(y + (start + r) * kColumns);
      y_r[0] = low[r];
      y_r[1] = high[r];
    }
  }
}

}  // namespace samara::models::added_mass
