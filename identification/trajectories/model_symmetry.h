#pragma once

#include <string>
#include <vector>

#include "samara/identification/trajectories/trajectory_source.h"
#include "samara/models/interface/parametric_model.h"

/// Internal to identification/.
namespace samara::identification {

/// The outputs that a "translation of ..." among the model's symmetries shifts.
std::vector<std::string> translated_outputs(const models::ModelInfo& model,
                                            const std::vector<FitOutput>& outputs);

/// The four outputs that hold the model's attitude quaternion (w, x, y, z), if all are there; else none.
std::vector<std::string> attitude_outputs(const models::ModelInfo& model,
                                          const std::vector<FitOutput>& outputs);

/// Whether the equations are the same at several times, to round-off, in the middle of the box.
bool is_autonomous(const models::ParametricModel& equations, const std::vector<FitCoordinate>& box);

/// What a family says of the equations behind it, beyond its coordinates and outputs.
void describe_equations(const models::ParametricModel& equations, FamilyInfo& info);

}  // namespace samara::identification
