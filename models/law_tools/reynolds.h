#pragma once

#include "samara/models/law_tools/parameter_list.h"

/// Coefficients as functions of the Reynolds number Re = l U / nu, smooth, written once for all laws:
///
///   drag C_D (1 + Re_drag / Re), which tends to a drag linear in the velocity,
///   lift C / (1 + Re_lift / Re), which tends to none;
///
/// constant for Re_drag = Re_lift = 0, the defaults, and affine in the coefficients throughout. For a sphere
/// Re_drag = 24 / C_D gives Stokes' drag at small Re.
namespace samara::models::laws {

/// The speeds at which Re is Re_drag and Re_lift [m/s].
template <class S>
struct ReynoldsSpeeds {
  S drag = S(0.0);
  S lift = S(0.0);
};

/// @param nu kinematic viscosity [m^2/s] @param length l [m]
template <class S>
ReynoldsSpeeds<S> reynolds_speeds(const S& Re_drag, const S& Re_lift, const S& nu, const S& length) {
  const S one = nu / length;
  return {Re_drag * one, Re_lift * one};
}

/// U (1 + Re_drag / Re): what stands for U in a drag C_D U u. Finite at rest. [m/s]
template <class S>
S drag_speed(const S& U, const S& speed_of_Re_drag) {
  return U + speed_of_Re_drag;
}

inline ParameterInfo Re_drag(const char* of_Re) {
  ParameterInfo parameter = not_negative("Re_drag", "1", 0.0, "");
  parameter.description = std::string("drag coefficients are C (1 + Re_drag/Re), ") + of_Re;
  return parameter;
}

inline ParameterInfo Re_lift() {
  return not_negative("Re_lift", "1", 0.0, "lift coefficients are C/(1 + Re_lift/Re)");
}

inline ParameterInfo viscosity_of_air() {
  return with_default(positive("nu", "m^2/s", "kinematic viscosity, in Re; default: air at 20 degrees C"),
                      1.516e-5);
}

inline ParameterInfo viscosity_of_water() {
  return with_default(positive("nu", "m^2/s", "kinematic viscosity, in Re; default: water at 20 degrees C"),
                      1.004e-6);
}

}  // namespace samara::models::laws
