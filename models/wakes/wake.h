#pragma once

#include "samara/models/law_tools/parameter_list.h"

/// What the wake and the separation of the flow add to quasi-steady forces on a plate, in the plane and in space.
///
/// **Memory.** After a jump of velocity or attitude, half of the circulation of attached flow is there at once, and the
/// rest comes while the vortices that were shed drift away (H. Wagner, Z. angew. Math. Mech. 5 (1925) 17-35). The share
/// `memory` of a circulation follows its quasi-steady value q by
///
///   G' = |u| (q - G) / (lag l),   circulation in all: (1 - memory) q + memory G,
///
/// with the chord l: `lag` is a time in chords travelled. With the defaults, memory 1/2 and lag 3.4, a jump is answered
/// within 0.042 of the jump as R. T. Jones approximates Wagner's function (NACA Rep. 681, 1940),
/// 1 - 0.165 exp(-0.0455 s) - 0.335 exp(-0.3 s), s = 2 |u| t/l: that lag errs least of all with one exponential.
/// memory = 0 is the quasi-steady law exactly, and lag -> 0 its limit. Lift stays normal to the velocity: it takes no
/// power, whatever is remembered. What the wake holds of the energy of the body (induced drag) is left out.
///
/// **Separation.** The share of attached flow is f = 1/(1 + (sin^2 alpha / sin^2 stall_angle)^2), smooth everywhere.
/// Attached flow adds C_TA to C_T and C_DA to the drag broadside, and the centre of pressure lies at
///
///   (f (cp_attached - cp_slope sin^2 alpha) + (1 - f) cp_separated) cos alpha   chords
///
/// before the plate's centre, towards the leading edge. The form is that of H. Li, T. Goodwill, Z. J. Wang,
/// L. Ristroph, J. Fluid Mech. 937 (2022) A6, whose transition is f = (1 - tanh((alpha - 14 deg)/6 deg))/2 and whose
/// angles are here smooth functions of the velocity. Their coefficients are here
///
///   C_T 0.95, C_TA 1.65, C_D0 0.1, C_D90 1.9, C_DA 3.1, C_R 1.1, cp_attached 0.3, cp_slope 3.0, cp_separated 0.17,
///
/// with kappa = 0 (they have no moment of Munk's), which keeps within 0.09 of their lift coefficient, 0.12
/// of their drag coefficient and 0.014 chords of their centre of pressure at every angle. All of it is 0
/// by default: forces act at the centre.
namespace samara::models::laws {

/// The share of attached flow. @param sine_2 sin^2 of the angle of attack @param stall_sine_2 that of the stall angle
template <class S>
S attached_share(const S& sine_2, const S& stall_sine_2) {
  const S over = sine_2 / stall_sine_2;
  return S(1.0) / (S(1.0) + over * over);
}

/// The centre of pressure over the cosine of the angle of attack. [chords]
/// @param cp cp_attached, cp_slope, cp_separated
template <class S>
S pressure_offset(const S* cp, const S& attached, const S& sine_2) {
  return attached * (cp[0] - cp[1] * sine_2) + (S(1.0) - attached) * cp[2];
}

/// Where they stand in wake_parameters().
enum WakeParameter {
  kMemoryT,
  kMemoryR,
  kLagT,
  kLagR,
  kCTA,
  kCDA,
  kStallAngle,
  kCp,  ///< three: attached, slope, separated
  kWakeParameters = kCp + 3
};

/// By WakeParameter, with Wagner's memory, and without separation.
Parameters wake_parameters();

}  // namespace samara::models::laws
