#pragma once

#include <vector>

#include "samara/models/batch/lanes.h"
#include "samara/models/stochastic/gust_layout.h"

namespace samara::models {

/// The time in which drag takes up a change of the air, from what any model tells of its forces: the momentum
/// u_r . (m + M) u_r / |F . u_r| along the relative velocity, F the forces of the fluid: all terms of the
/// model but those of kNotDrag. For drag alone it is |(m + M) u_r| / |F|.
class ResponseTime {
 public:
  /// The parameters are those of the model at a point; gusts are set by the call.
  ResponseTime(const ParametricModel& model, std::span<const double> point, const GustLayout& layout);

  /// [s]; infinite where the body moves with the fluid, 0 for a model that lists neither forces nor an energy.
  double operator()(const Lanes& lanes, int lane, double t, const Eigen::Vector3d& air);

 private:
  const Model& model_;
  const GustLayout& layout_;
  std::vector<char> is_of_fluid_;  ///< by force term
  ParameterValues p_;
  std::vector<double> x_;
  std::vector<Wrench> terms_;
};

}  // namespace samara::models
