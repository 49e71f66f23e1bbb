#pragma once

#include <string>
#include <vector>

#include "samara/models/interface/parametric_model.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Internal to models/.
namespace samara::models {

/// The outputs that a "translation of ..." among the model's symmetries shifts.
std::vector<std::string> translated_outputs(const ModelInfo& model, const std::vector<FamilyOutput>& outputs);

/// The four outputs that hold the model's attitude quaternion (w, x, y, z), if all are there; else none.
std::vector<std::string> attitude_outputs(const ModelInfo& model, const std::vector<FamilyOutput>& outputs);

/// Where the question is asked whether equations know the time.
struct PointOfMotion {
  std::vector<double> q;  ///< coordinates of the box
  std::vector<double> x;  ///< states
};

/// The middle of the box, then points off it and a little off their start: where a motion rests, or an amplitude is
/// zero, what depends on time may have no effect.
std::vector<PointOfMotion> points_of_motion(const ParametricModel& equations,
                                            const std::vector<FamilyCoordinate>& box);

/// 32 times from 0.01 to 100 s, evenly in their logarithms and without a period.
std::vector<double> times_of_motion();

/// Whether equations as text do not mention the time; of others, whether they are the same at all these times, to
/// round-off, at all these points. Points without rates do
/// not count; where there are no others they are not.
bool is_autonomous(const ParametricModel& equations, const std::vector<FamilyCoordinate>& box);

/// Fills what a family says of its equations, beyond coordinates and outputs.
void describe_equations(const ParametricModel& equations, FamilyInfo& info);

}  // namespace samara::models
