#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/model.h"

/// Where a body stands in the measured phase diagram of falling discs: S. B. Field, M. Klaus, M. G. Moore, F. Nori,
/// Chaotic dynamics of falling disks, Nature 388 (1997) 252-254, with the discs of W. W. Willmarth, N. E. Hawk, R. L.
/// Harvey, Phys. Fluids 7 (1964) 197-208, and others: Re from 20 to 4e4, I* from 2e-4 to 0.5.
///
/// The boundaries are lines of few points, rounded: 97 % of the 347 measured discs lie on their right side, the others
/// within 0.1 of one. They hold for discs; of other outlines the numbers of the disc with the same diameter are taken,
/// which is a guess. A phase diagram has one word at each place where measurements see several: Tinklenberg, Guala and
/// Coletti (J. Fluid Mech., 2023) find discs in air, at I* of order 1, to fall straight or to tumble at the same point,
/// both often.
namespace samara::motion {

enum class Regime { steady, periodic, chaotic, tumbling };
std::string to_string(Regime regime);

struct RegimeAnswer {
  Regime regime = Regime::steady;
  double distance = 0.0;           ///< to the nearest boundary, in units of ln Re and ln I*
  Regime beyond = Regime::steady;  ///< what lies on its other side
  bool measured = false;           ///< whether the point lies where discs were measured
};

/// @param I_disc inertia ratio of a disc, see models/bodies/scaling_numbers.h
/// @throws ArgumentError if one is not positive and finite.
RegimeAnswer regime(double Re, double I_disc);

/// A boundary of the diagram: columns Re, I*.
struct RegimeBoundary {
  std::string name;
  Eigen::MatrixX2d points;
};
const std::vector<RegimeBoundary>& regime_boundaries();

/// Where discs were measured.
struct MeasuredDiscs {
  double least_Re, most_Re, least_I, most_I;
};
inline constexpr MeasuredDiscs kMeasuredDiscs = {20.0, 4e4, 2e-4, 0.5};

/// The boundaries drawn on to the ends of what was measured, as regime() takes them.
std::vector<RegimeBoundary> drawn_regime_boundaries();

/// What a body and its fluid are to phase diagrams.
struct FallNumbers {
  double length = 0.0, thickness = 0.0;             ///< m, full
  double solid_density = 0.0, fluid_density = 0.0;  ///< kg/m^3
  double viscosity = 0.0, gravity = 0.0;            ///< kinematic, m^2/s; m/s^2
  double speed = 0.0;                               ///< sqrt(|rho_s/rho_f - 1| g t), m/s
  double Re = 0.0, I_disc = 0.0, I_plate = 0.0, I_ellipse = 0.0;
};

/// From the parameters of a model that has a body: semi-axes a, b, c; semi_chord and semi_thickness; chord and
/// thickness; or area and thickness, with density, fluid_density, g and nu.
/// @param parameters all of them, complete
/// @throws ArgumentError if the model does not say what is needed.
FallNumbers fall_numbers(const models::Model& model, const std::vector<double>& parameters);

}  // namespace samara::motion
