#pragma once

#include <array>

#include "samara/flow/grid/borders.h"
#include "samara/flow/grid/openness.h"
#include "samara/flow/grid/rows.h"

namespace samara::flow {

/// Largest share of a cell that flows out of it, or into it, per time.
double fastest_exchange(const MacGrid& grid, const Openness& open, const FaceField& velocity, RowSums& rows);

/// Advection and diffusion of a scalar that stay within the bounds of what was there.
///
/// Advection is one Euler step with van Leer's slopes. While at most half of a cell's content flows out of it in a
/// step, all directions together, the new value is a mean of old ones with positive weights: a face value is at
/// least 2 s - max and at most 2 s - min of its neighbours, so that neither 0 nor the largest value is passed.
/// (Limits by the largest single component of the velocity allow the double in the plane and let values become
/// negative.) Diffusion is implicit in directional factors, M-matrices all, for any step. Both conserve the sum of
/// V s but for what crosses the borders.
class MonotoneTransport {
 public:
  /// @param grid, borders, open must outlive this object
  MonotoneTransport(const MacGrid& grid, const Borders& borders, const Openness& open);

  /// Beside a body that moves, what flows into a cell is not what flows out: the body sweeps the rest. From now on,
  /// cells gain s times that difference, so that a uniform s stays uniform; it counts as entered.
  void follow_body() { sweeps_ = true; }
  /// a u of all faces; call it when the velocity has changed. @returns fastest_exchange()
  double set_velocity(const FaceField& velocity);
  /// s := after `step`, of at most half the inverse of that rate. @param given values at inflows
  /// and walls (fill_margins), also those of what comes back through an outflow @returns what
  /// entered through the borders, sum of V s
  double advect(Field& s, double step, const std::array<double, 6>& given, double returning);
  /// s := after diffusion with viscosity + eddy/sigma. @returns what entered from walls with given values
  double diffuse(Field& s, double step, double viscosity, const Field* eddy, double sigma,
                 const std::array<double, 6>& given);

 private:
  double add_swept(const double* old, Field& s, double scale) const;

  const MacGrid& grid_;
  const Borders& borders_;
  const Openness& open_;
  bool sweeps_ = false;
  FaceField discharge_;
  Field before_, ratio_, turn_;
  RowSums sums_;
};

}  // namespace samara::flow
