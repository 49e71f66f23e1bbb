#pragma once

#include "samara/models/integrators/integrate.h"

/// What the integrator promises at the end: each of its N steps errs by at most relative * (|x_i| + scale_i)
/// in a norm over n components (so sqrt(n) times that in one of them), |x_i| stays below a few scales in
/// these tests, and the equations here forget errors or carry them along unamplified. Hence N * relative * (a
/// few) * scale.
inline double promised(const samara::models::Trajectory& trajectory, double relative, double largest) {
  return static_cast<double>(trajectory.steps + 1) * relative * 3.0 * largest;
}
