#pragma once

#include "samara/flow/grid/mac_grid.h"

/// The flux of momentum through the faces of the velocities' control volumes: one formula for the step and for the
/// balances that check it.
namespace samara::flow {

/// How the velocity on a face of a control volume comes from its neighbours.
enum class AdvectionScheme {
  central,   ///< their mean: second order, conserves energy; laminar verification
  van_leer,  ///< upwind with van Leer's slopes: second order where smooth, bounded
};

/// Van Leer's reconstruction halfway from the middle of three values towards `down` (B. van Leer, J. Comput. Phys. 14
/// (1974) 361): it stays between the middle value and both neighbours.
[[gnu::always_inline]] inline double van_leer_value(double up, double middle, double down) {
  const double before = middle - up, after = down - middle;
  const double product = before * after;
  // Where both differences have one sign their sum is not 0. The quotient is taken everywhere, for vectors.
  const double half_slope = product / (before + after);
  return product > 0.0 ? middle + half_slope : middle;
}

/// What the flux of u_d across direction j needs. All fields have filled margins.
struct FluxInput {
  const double* u = nullptr;           ///< u_d at the start of the step, which diffuses
  const double* carried = nullptr;     ///< u_d, extrapolated to the middle of the step, which is advected
  const double* along = nullptr;       ///< u_j, extrapolated
  const double* discharge = nullptr;   ///< a_j u_j, extrapolated
  const double* conduction = nullptr;  ///< Openness::conduction of d and j
  const double* eddy = nullptr;        ///< nu_T of cells; null: laminar
  Index own = 0, across = 0;           ///< strides of d and j
  double viscosity = 0.0;              ///< molecular
  double per_spacing = 0.0;            ///< 1/h
};

/// nu_T on that face: of the cell that it halves, or of the four around an edge.
template <bool kNormal>
[[gnu::always_inline]] inline double eddy_viscosity(const FluxInput& in, Index c) {
  if constexpr (kNormal) return in.eddy[c - in.own];
  return 0.25 * (in.eddy[c] + in.eddy[c - in.own] + in.eddy[c - in.across] + in.eddy[c - in.own - in.across]);
}

/// Flux of u_d through the lower face, across j, of the control volume of face c, per area [U^2]:
///
///   m u - A (nu + nu_T) du_d/dx_j - A nu_T du_j/dx_d,   m = (discharge of both cells)/2
///
/// with A by h over the distance of both velocities where one of them stands beside the body.
/// The last term is the transposed part of 2 nu_T S; with nu alone it sums to 0 and is left out.
template <AdvectionScheme kScheme, bool kEddy, bool kNormal>
[[gnu::always_inline]] inline double momentum_flux(const FluxInput& in, Index c) {
  const Index s = in.across;
  const double mass = 0.5 * (in.discharge[c - in.own] + in.discharge[c]);
  const double* const u = in.carried + c;
  double value;
  if constexpr (kScheme == AdvectionScheme::central) {
    value = 0.5 * (u[-s] + u[0]);
  } else {
    const bool onward = mass > 0.0;
    const double up = onward ? u[-2 * s] : u[s];
    const double middle = onward ? u[-s] : u[0];
    const double down = onward ? u[0] : u[-s];
    value = van_leer_value(up, middle, down);
  }
  const double area = in.conduction[c] * in.per_spacing;
  double stress = in.viscosity * (in.u[c] - in.u[c - s]);
  if constexpr (kEddy) {
    const double eddy = eddy_viscosity<kNormal>(in, c);
    stress += eddy * ((in.u[c] - in.u[c - s]) + (in.along[c] - in.along[c - in.own]));
  }
  return mass * value - area * stress;
}

}  // namespace samara::flow
