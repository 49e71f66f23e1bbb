#pragma once

#include <cstddef>

/// The inner loops of the panel solver, over structures of arrays; compiled also for wider vector registers
/// and chosen when the program is loaded.
namespace samara::models::added_mass {

/// So many rows (points, or outer panels) are worked on at once, as lanes of vector registers.
inline constexpr std::size_t kLanes = 16;

/// Rows: points with second moments (zero for mere points), xx, yy, zz, xy, yz, zx.
struct LanePoints {
  alignas(64) double x[3][kLanes];
  alignas(64) double moment[6][kLanes];
};

/// One panel as seen from far away.
struct FarPanel {
  double centroid[3];
  double normal[3];
  double area_over_4pi;
  double moment[6];
  double radius;
};

/// For each panel and lane the mean over the lane of Int G dS up to second moments, and r^2 of the centroids.
/// Outputs are panels x kLanes.
void far_sources(const FarPanel* panels, std::size_t n, const LanePoints& points, double* source, double* r2);

/// Int dG/dn dS of each panel for each lane by its centroid. Output as above.
void far_dipoles(const FarPanel* panels, std::size_t n, const LanePoints& points, double* dipole);

/// out[r kLanes + lane] += factor[r] * in[lane] for r < rows.
void add_outer(const double* in, const double* factor, std::size_t rows, double* const* out);

/// y (n x kColumns) = A x, A n x n by rows, rows first..last.
inline constexpr std::size_t kColumns = 8;
void multiply_rows(const double* A, std::size_t n, std::size_t first, std::size_t last, const double* x,
                   double* y);

}  // namespace samara::models::added_mass
