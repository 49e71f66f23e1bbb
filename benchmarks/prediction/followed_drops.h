#pragma once

#include <map>
#include <string>
#include <vector>

#include "identification/windows.h"
#include "samara/identification/captures/capture.h"
#include "samara/identification/following/noise_search.h"
#include "samara/identification/problem/fit_result.h"

/// What comes next of falling paper, from all that was seen of a drop: a filter of the body (following/follower.h).
namespace samara::benchmarks::prediction {

class FollowedDrops {
 public:
  /// @param drops all of them, whole
  /// @param fitted the body's coefficients @param training windows of the drops on which noise is chosen
  FollowedDrops(const std::vector<samara::identification::Capture>& drops,
                const samara::identification::FitResult& fitted,
                const std::vector<identification::Window>& training);

  /// m: the mean of what is forecast for the next time of a window, from the drop up to the window's last frame; NaN
  /// where the motion was not followed then.
  Eigen::RowVector3d next(const identification::Window& window) const;

  const samara::identification::NoiseChoice& noise() const { return noise_; }

 private:
  samara::identification::FollowOptions options_of(const samara::identification::Capture& drop) const;

  std::map<std::string, samara::identification::Capture> drops_;  ///< by label
  samara::identification::FitResult fitted_;
  samara::identification::NoiseChoice noise_;
};

}  // namespace samara::benchmarks::prediction
