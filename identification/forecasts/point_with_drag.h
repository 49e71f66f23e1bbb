#pragma once

#include <Eigen/Core>

#include "samara/identification/forecasts/baseline_scores.h"

/// Internal to identification/.
namespace samara::identification {

/// x'' = -w up - k |v| v, w the net weight, with start, velocity and k (0 or more) of the span's own, by least
/// squares to all frames that show every component. NaN where no component is up or fewer than 4 frames do.
Eigen::MatrixXd predict_point_with_drag(const SeenMotion& span, const Eigen::VectorXd& times);

}  // namespace samara::identification
