#pragma once

/// Added mass of plane sections in an unbounded ideal fluid, per unit span: the body axis x' lies along the
/// chord, y' along the normal, and the kinetic energy of the fluid is 1/2 (m11 vx^2 + m22 vy^2 + I_a w^2)
/// with the velocity of the centre.
namespace samara::models {

struct PlanarAddedMass {
  double m11 = 0.0;  ///< for motion along the chord [kg/m]
  double m22 = 0.0;  ///< for motion along the normal [kg/m]
  double I_a = 0.0;  ///< for rotation about the centre [kg m]
};

/// Ellipse with semi-chord a and semi-thickness b [m]: pi rho b^2, pi rho a^2, pi/8 rho (a^2-b^2)^2, exact
/// (H. Lamb, Hydrodynamics, 6th ed., 1932, art. 71). b = 0 is a flat plate.
/// @throws ArgumentError if a or the density [kg/m^3] is not a positive number, or b is negative or no
/// number.
PlanarAddedMass planar_ellipse_added_mass(double a, double b, double fluid_density);

/// Rectangle with full sides a (chord) and b (thickness) [m] as used in models of falling rectangular plates:
/// 3 pi/8 rho b^2, 3 pi/8 rho a^2, 5 pi/256 rho (a^2-b^2)^2. These are fitted, not exact: a flat plate of
/// chord a has pi/4 rho a^2. @throws as above.
PlanarAddedMass planar_rectangle_added_mass(double a, double b, double fluid_density);

}  // namespace samara::models
