#pragma once

#include <map>
#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/pgd/tensors/random.h"

/// The reference plate before a camera: 60 frames over six characteristic times, with a noise of 1 % of the
/// chord and 2 degrees.
namespace samara::benchmarks::identification {

struct Truth {
  std::string name;
  double value;
};
const std::vector<Truth>& plate_coefficients();

/// What a fit does not touch.
std::map<std::string, double> plate_fixed(double inertia_ratio);

/// The developed motion, seen by a camera from a random moment on.
samara::identification::Capture plate_capture(double inertia_ratio, pgd::Random& random);

/// Everything a fit frees, with room.
std::map<std::string, samara::models::Interval> plate_box();

samara::identification::FitOptions plate_options();

}  // namespace samara::benchmarks::identification
