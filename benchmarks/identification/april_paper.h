#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/models/trajectories/trajectory_family.h"

/// One drop of a paper card with a tag on each side, as three cameras saw it: poses that flip, gaps, a body
/// of unknown shape and size. What a fit of a body in space may still claim.
namespace samara::benchmarks::identification {

/// Runs of frames without long gaps, of every camera, wrong poses taken out; labels `cam` and `drop`.
std::vector<samara::identification::Capture> april_windows(const std::filesystem::path& folder);

/// @param size m, radius of the disc that stands for the card, which is not known
std::unique_ptr<samara::models::TrajectoryFamily> april_family(double size);
samara::identification::FitOptions april_options();

/// The size that is assumed: 5 cm square, around tags of 34 mm.
inline constexpr double kAprilSize = 0.028;

/// The same fit under something that nobody knows better.
struct AprilVariant {
  std::string doubt = {};  ///< "the size of the card"
  samara::identification::FitResult fit = {};
};

/// A card half as large again; angles that are believed a third as much; and without each of the cameras.
/// @param cameras whether to leave them out, one by one
std::vector<AprilVariant> april_variants(const std::vector<samara::identification::Capture>& windows,
                                         bool cameras);

/// What may be said of one coefficient.
struct AprilVerdict {
  std::string name = {};
  double value = 0.0;
  /// Of the logarithm, from the scatter between windows; of the prior where there is none.
  double error = 0.0;
  double change = 0.0;  ///< of the logarithm, the largest of the variants
  bool identified = false;
  std::string words = {};
};

/// A coefficient counts as identified if the windows leave it within a factor of 1.35, no variant moves it
/// farther, and it lies at no bound.
std::vector<AprilVerdict> april_verdicts(const samara::identification::FitResult& fitted,
                                         const std::vector<AprilVariant>& variants);

}  // namespace samara::benchmarks::identification
