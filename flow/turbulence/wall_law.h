#pragma once

#include <cmath>

/// The logarithmic law beside a wall, in the form that k carries (B. Launder, D. Spalding, Comput. Methods Appl.
/// Mech. Eng. 3 (1974) 269): u_tau = C_mu^{1/4} k^{1/2} does not vanish where the flow separates.
namespace samara::flow {

/// Constants of the model, as Launder and Spalding give them.
struct KEpsilonConstants {
  static constexpr double C_mu = 0.09, C_1 = 1.44, C_2 = 1.92, sigma_k = 1.0, sigma_epsilon = 1.3;
};

struct WallLaw {
  static constexpr double kKarman = 0.41, kRoughness = 9.8;  ///< kappa and E of a smooth wall
  static constexpr double kViscousReach = 11.5;              ///< y+ below which the profile is linear

  double friction_velocity;  ///< u_tau = C_mu^{1/4} k^{1/2}
  double y_plus;
  double conductance;  ///< tau_w/u_t: kappa u_tau/ln(E y+), or nu/y in the viscous layer

  WallLaw(double k, double distance, double viscosity)
      : friction_velocity(std::sqrt(std::sqrt(KEpsilonConstants::C_mu) * k)),
        y_plus(friction_velocity * distance / viscosity),
        conductance(y_plus > kViscousReach ? kKarman * friction_velocity / std::log(kRoughness * y_plus)
                                           : viscosity / distance) {}
};

}  // namespace samara::flow
