#pragma once

#include <span>
#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Whether a fit looks as if the body had another mass.
///
/// A wrong mass shows in nothing that is measured: coefficients take it up as far as their boxes let them,
/// and what is left are residuals. So the fit is repeated with the mass (or the density) that was held
/// multiplied by powers of ten. Where one of them explains the captures far better, and with coefficients
/// inside their boxes, the mass that was given is in doubt.
namespace samara::identification {

/// A warning in one sentence, or none: if no coefficient of the fit lies at a bound and no output is missed
/// by many loss scales, if neither "mass" nor "density" was held, or if no power of ten does much better.
/// @param family, captures, options those of the fit; the family must know its equations
std::vector<std::string> check_mass(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                                    const FitOptions& options, const FitResult& fitted);

}  // namespace samara::identification
