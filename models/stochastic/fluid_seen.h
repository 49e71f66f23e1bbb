#pragma once

#include <cstdint>
#include <memory>

#include "samara/models/stochastic/air_along_path.h"
#include "samara/models/stochastic/turbulent_flow.h"

/// The velocity of the fluid that a body sees in turbulence: mean plus sigma w, sigma^2 = 2 k/3, where w follows the
/// normalised Langevin equation along the path of the body, by component
///
///   dw = -w/T dt + d sigma/dx dt + sqrt(2/T) dW,     T = 4 k/(3 C_0 epsilon).
///
/// w has unit variance everywhere, whatever T does, and the drift keeps fluid that is well mixed so (without it
/// particles gather where k is small). A body that crosses the eddies sees them pass in a shorter time, along its
/// relative velocity T/sqrt(1 + b^2 s^2), across it T/sqrt(1 + 4 b^2 s^2), with s its mean relative velocity over
/// sigma, b = 0.565 (6/C_0). The mean is over the last 10 T: of what is random a tenth of the variance is left in it,
/// so that bodies without a drift through the fluid see T too short: with C_0 = 6.5 by less than a tenth, more for
/// small C_0. A step is exact for whatever length while T and the gradient hold.
///
/// D. J. Thomson, J. Fluid Mech. 180 (1987) 529-556; J. D. Wilson, B. J. Legg, D. J. Thomson, Boundary-Layer
/// Meteorol. 27 (1983) 163-169; J.-P. Minier, E. Peirano, Phys. Rep. 352 (2001) 1-214, for crossing trajectories.
namespace samara::models {

/// C_0 of the structure function <du^2> = C_0 epsilon tau by the Reynolds number of Taylor's scale,
/// 6.5 (1 + 140 Re_lambda^(-4/3))^(-3/4) (dissertation (4.11), corrected); 0 at rest.
/// @throws ArgumentError unless Re_lambda >= 0 and finite.
double structure_constant(double Re_lambda);

/// The share of the variance that is left of a velocity averaged over a disc, along its normal, in isotropic turbulence
/// with von Karman's spectrum: 1 for a point.
/// @param radius_over_scale a/L, with L = 0.43 k^(3/2)/epsilon the scale of that spectrum; not negative
double disc_attenuation(double radius_over_scale);

/// One exact step of dw = -w/T dt + sqrt(2/T) dW, and of its integral over time.
struct LangevinStep {
  /// @param steps h/T, not negative; infinite: nothing is left of the old value
  explicit LangevinStep(double steps);

  double kept;    ///< exp(-h/T) of the old value is kept
  double noise;   ///< sqrt(1 - kept^2), times a standard normal is added
  double carry;   ///< integral over T: carry times the old value ..
  double shared;  ///< .. plus shared times that normal ..
  double rest;    ///< .. plus rest times another one
};

struct SeenOptions {
  double C_0 = 0.0;           ///< 0: structure_constant() of the local Reynolds number
  double viscosity = 1.5e-5;  ///< kinematic, of that Reynolds number [m^2/s]; default: air
  bool crossing = true;       ///< shorter times for bodies that cross the eddies
  /// The body averages the fluid over a disc of this radius [m]; 0: a point. (disc_attenuation() for all components;
  /// the gradient of L is neglected.)
  double radius = 0.0;
  /// A rotational gust by the eddies larger than the body, of deviation 0.99 (epsilon/l^2)^(1/3) and time
  /// (l^2/epsilon)^(1/3), l = 2 radius: it is not yet based on measurements.
  bool rotation = false;
};

/// The fluid seen in a turbulent flow, to be given to realise().
/// @throws ArgumentError if there is no flow, or an option is outside its meaning (a rotation without a radius).
std::shared_ptr<const AirSource> fluid_seen_in(std::shared_ptr<const TurbulentFlow> flow, std::uint64_t seed,
                                               const SeenOptions& options = {});

}  // namespace samara::models
