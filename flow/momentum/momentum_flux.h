#pragma once

#include "samara/flow/grid/rows.h"

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
template <class V>
[[gnu::always_inline]] inline V van_leer_value(const V& up, const V& middle, const V& down) {
  const V before = middle - up, after = down - middle;
  const V product = before * after;
  // Where both differences have one sign their sum is not 0. The quotient is taken everywhere, for vectors.
  const V half_slope = product / (before + after);
  return product > 0.0 ? middle + half_slope : middle;
}

/// The value on the face between the second and the third of four in a line, from where `mass` comes.
template <class V>
[[gnu::always_inline]] inline V upwind_value(const V& mass, const V& first, const V& second, const V& third,
                                             const V& fourth) {
  const auto onward = mass > 0.0;
  return van_leer_value<V>(onward ? first : fourth, onward ? second : third, onward ? third : second);
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
template <class V, bool kNormal>
[[gnu::always_inline]] inline V eddy_viscosity(const FluxInput& in, Index c) {
  const double* const eddy = in.eddy + c;
  if constexpr (kNormal) return load<V>(eddy - in.own);
  return 0.25 * (load<V>(eddy) + load<V>(eddy - in.own) + load<V>(eddy - in.across) +
                 load<V>(eddy - in.own - in.across));
}

/// Flux of u_d through the lower face, across j, of the control volume of face c, per area [U^2]:
///
///   m u - A (nu + nu_T) du_d/dx_j - A nu_T du_j/dx_d,   m = (discharge of both cells)/2
///
/// with A by h over the distance of both velocities where one of them stands beside the body.
/// The last term is the transposed part of 2 nu_T S; with nu alone it sums to 0 and is left out.
template <class V, AdvectionScheme kScheme, bool kEddy, bool kNormal>
[[gnu::always_inline]] inline V momentum_flux(const FluxInput& in, Index c) {
  const Index s = in.across;
  const V mass = 0.5 * (load<V>(in.discharge + c - in.own) + load<V>(in.discharge + c));
  const double* const u = in.carried + c;
  V value = load<V>(u - s);
  if constexpr (kScheme == AdvectionScheme::central) {
    value = 0.5 * (value + load<V>(u));
  } else {
    value = upwind_value(mass, load<V>(u - 2 * s), value, load<V>(u), load<V>(u + s));
  }
  const V area = load<V>(in.conduction + c) * in.per_spacing;
  const V across = load<V>(in.u + c) - load<V>(in.u + c - s);
  V stress = in.viscosity * across;
  if constexpr (kEddy)
    stress += eddy_viscosity<V, kNormal>(in, c) *
              (across + (load<V>(in.along + c) - load<V>(in.along + c - in.own)));
  return mass * value - area * stress;
}

}  // namespace samara::flow
