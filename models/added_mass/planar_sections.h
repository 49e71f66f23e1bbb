#pragma once

#include <numbers>

/// Added mass of plane sections per unit span, for any scalar: the formulas of planar.h.
namespace samara::models::added_mass {

template <class S>
struct SectionAddedMass {
  S m11;  ///< along the chord [kg/m]
  S m22;  ///< along the normal [kg/m]
  S I_a;  ///< about the centre [kg m]
};

/// (a^2 - b^2)^2 without cancellation.
template <class S>
S squared_difference_of_squares(const S& a, const S& b) {
  const S d = (a - b) * (a + b);
  return d * d;
}

/// Ellipse of semi-axes a, b (H. Lamb, Hydrodynamics, 6th ed., 1932, art. 71).
template <class S>
SectionAddedMass<S> ellipse_section(const S& a, const S& b, const S& fluid_density) {
  const S k = S(std::numbers::pi) * fluid_density;
  return {k * b * b, k * a * a, S(0.125) * k * squared_difference_of_squares(a, b)};
}

/// Rectangle of full sides a, b, as fitted in models of falling plates.
template <class S>
SectionAddedMass<S> rectangle_section(const S& a, const S& b, const S& fluid_density) {
  const S k = S(3.0 * std::numbers::pi / 8.0) * fluid_density;
  return {k * b * b, k * a * a,
          S(5.0 * std::numbers::pi / 256.0) * fluid_density * squared_difference_of_squares(a, b)};
}

}  // namespace samara::models::added_mass
