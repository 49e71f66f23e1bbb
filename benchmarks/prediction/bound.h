#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "scored_split.h"

/// What a perfect model could reach: motions that a fitted body makes itself, seen for as long, as often and with as
/// much noise as measured ones, and forecast by the same body. What is then left is the start, which noisy places
/// must show, and the noise of the place that is judged.
namespace samara::benchmarks::prediction {

/// Standard deviations of single frames of the source (x, y, z) [m], found from fifth differences of places: what
/// moves adds little to them. Medians: jumps count as little.
/// @param averaged frames of the source's noise, white before, of which a frame is the mean
Eigen::RowVector3d noise_of(std::span<const samara::identification::Capture> motions, int averaged = 1);

struct Bound {
  const samara::models::TrajectoryFamily* family = nullptr;
  samara::identification::FitOptions options = {};
  identification::Coefficients coefficients = {};  ///< with which motions are made, and forecast
  Eigen::RowVector3d noise = Eigen::RowVector3d::Zero();
  int averaged = 1;  ///< as of noise_of()
  /// The window as a moment, with what the body says of the next place.
  std::function<AskedMoment(const identification::Window&, const Eigen::RowVectorXd&)> moment_of = {};
};

/// Rows of `report()` for motions made such as those of measured windows began, with `suffix`: trained on the ones,
/// asked of the others. Beside these, "judged_noise": the median distance that the noise of one place makes.
/// Windows where the body has no motion are left out.
void report_bound(const std::string& test_case, const std::string& suffix, const Bound& bound,
                  std::span<const identification::Window> training,
                  std::span<const identification::Window> unseen);

}  // namespace samara::benchmarks::prediction
