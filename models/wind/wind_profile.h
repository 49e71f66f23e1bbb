#pragma once

#include <memory>

#include "samara/models/stochastic/turbulent_flow.h"

/// The mean wind over flat ground, and the turbulent energy of the layer near it when the air is neither heated nor
/// cooled by the ground (the neutral surface layer).
///
/// Source: H. Tennekes, J. L. Lumley, A First Course in Turbulence (1972), chapter 5; J. C. Kaimal, J. C. Wyngaard,
/// Y. Izumi, O. R. Cote, Spectral characteristics of surface-layer turbulence, Q. J. R. Meteorol. Soc. 98 (1972). Holds
/// over ground of one roughness for some hundred metres upwind, to heights of about 100 m.
namespace samara::models::wind {

/// Von Karman's constant, of the logarithmic profile.
inline constexpr double kKarman = 0.40;

enum class ProfileKind {
  uniform,      ///< U
  logarithmic,  ///< (u_star/kappa) ln((z - d)/z0) for z > d + z0, else 0
  power,        ///< U (z/h)^exponent for z > h/1000, linear in z below, 0 for z <= 0
};

/// What a profile is made of. Heights are above the ground, z = 0.
struct ProfileOptions {
  ProfileKind kind = ProfileKind::logarithmic;
  double speed = 0.0;    ///< U [m/s], at `height`
  double height = 10.0;  ///< h [m]
  /// z0 [m]: 0.03 grass, 0.3 farmland with hedges, 1 forest or town; logarithmic only.
  double roughness = 0.03;
  double displacement = 0.0;  ///< d [m]: about 2/3 of the height of a closed canopy; logarithmic only
  double exponent = 0.14;     ///< power only
};

/// Mean speed over height. Immutable.
class WindProfile {
 public:
  /// @throws ArgumentError for a speed below 0, a height, roughness or exponent that is not positive, a height that
  /// is not above displacement + roughness, or a number that is not finite.
  explicit WindProfile(const ProfileOptions& options);

  const ProfileOptions& options() const { return options_; }

  /// U(z) [m/s]
  double speed(double z) const;
  /// dU/dz [1/s], that of the side above where U has a kink.
  double shear(double z) const;
  /// u_star [m/s] of the logarithmic profile: kappa U/ln((h - d)/z0). @throws ArgumentError for another profile.
  double friction_velocity() const;
  /// Over which height the speed changes by its own size where the wind begins: ten times the roughness or the end of
  /// the straight line [m]; 0 for a uniform wind: there is none.
  double length() const;

 private:
  ProfileOptions options_;
};

enum class EnergyConstants {
  kaimal,    ///< k = 4.49 u_star^2: half the sum of the integrals of Kaimal's spectra
  k_epsilon  ///< k = u_star^2/sqrt(C_mu) = 3.33 u_star^2, with which the k-epsilon model holds in the layer
};

/// epsilon = u_star^3/(kappa z), where production and dissipation balance; k is the same at all heights.
/// @param z height above the displacement [m]
/// @throws ArgumentError unless both are positive and finite.
Turbulence surface_layer_turbulence(double friction_velocity, double z,
                                    EnergyConstants constants = EnergyConstants::kaimal);

/// The layer as a flow with energy, for bodies that see the fluid at random (fluid_seen.h): the mean wind of a
/// logarithmic profile along `towards` [rad, from x to y] and the energy above. Below displacement + roughness, and
/// under the ground, where nobody should look, the dissipation stays that of their top.
/// @throws ArgumentError for a profile of another kind, without wind, or a direction that is not finite.
std::shared_ptr<const TurbulentFlow> surface_layer(const WindProfile& profile, double towards = 0.0,
                                                   EnergyConstants constants = EnergyConstants::kaimal);

}  // namespace samara::models::wind
