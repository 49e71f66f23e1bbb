#pragma once

#include <numbers>

/// Added mass of plane sections in an unbounded ideal fluid, per unit span, for any scalar: the body axis x' lies along
/// the chord, y' along the normal, and the kinetic energy of the fluid is 1/2 (m11 vx^2 + m22 vy^2 + I_a w^2) with the
/// velocity of the centre. Internal to models/.
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

/// Ellipse of semi-axes a, b (H. Lamb, Hydrodynamics, 6th ed., 1932, art. 71). b = 0 is a flat plate.
template <class S>
SectionAddedMass<S> ellipse_section(const S& a, const S& b, const S& fluid_density) {
  const S k = S(std::numbers::pi) * fluid_density;
  return {k * b * b, k * a * a, S(0.125) * k * squared_difference_of_squares(a, b)};
}

/// Rectangle of full sides a, b, as in models of falling plates. Fitted, not exact: a flat plate of chord a has
/// pi/4 rho a^2, and this gives 3 pi/8.
template <class S>
SectionAddedMass<S> rectangle_section(const S& a, const S& b, const S& fluid_density) {
  const S k = S(3.0 * std::numbers::pi / 8.0) * fluid_density;
  return {k * b * b, k * a * a,
          S(5.0 * std::numbers::pi / 256.0) * fluid_density * squared_difference_of_squares(a, b)};
}

}  // namespace samara::models::added_mass
