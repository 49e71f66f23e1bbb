#pragma once

/// Numbers by which falling plates and discs are classified. l is the largest full length in the plane of the
/// body (chord, diameter), t its full thickness, both in m; densities in kg/m^3.
///
/// Three different ratios are all called I* in the literature; here each has its own name. All functions
/// throw ArgumentError if an argument is not a positive number.
namespace samara::models {

/// Terminal speed by order of magnitude, sqrt(|rho_s/rho_f - 1| g t) [m/s]; also for bodies that rise.
double fall_speed_scale(double solid_density, double fluid_density, double thickness, double gravity = 9.81);

/// Re = U l / nu with U the scale above and nu the kinematic viscosity [m^2/s].
double fall_reynolds_number(double solid_density, double fluid_density, double length, double thickness,
                            double kinematic_viscosity, double gravity = 9.81);

/// Of a circular disc of diameter d: pi rho_s t / (64 rho_f d) (W. W. Willmarth, N. E. Hawk, R. L. Harvey,
/// Phys. Fluids 7 (1964) 197-208; S. B. Field et al., Nature 388 (1997) 252-254).
double inertia_ratio_of_disc(double solid_density, double fluid_density, double diameter, double thickness);

/// Of a long rectangular plate of chord l: 8 rho_s t (l^2+t^2) / (3 pi rho_f l^3), its moment of inertia over
/// that of the fluid cylinder about it (E. H. Smith, J. Fluid Mech. 50 (1971) 513-534).
double inertia_ratio_of_plate(double solid_density, double fluid_density, double chord, double thickness);

/// Of a thin elliptic section with semi-axes a (half chord) and b: rho_s b / (rho_f a) (A. Andersen, U.
/// Pesavento, Z. J. Wang, J. Fluid Mech. 541 (2005) 65-90).
double inertia_ratio_of_ellipse(double solid_density, double fluid_density, double a, double b);

}  // namespace samara::models
