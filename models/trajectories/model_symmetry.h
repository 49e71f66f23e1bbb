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

/// Whether the equations are the same at several times, to round-off, in the middle of the box and at some points off
/// it. Points without rates do not count; where there are no others they are not.
bool is_autonomous(const ParametricModel& equations, const std::vector<FamilyCoordinate>& box);

/// Fills what a family says of its equations, beyond coordinates and outputs.
void describe_equations(const ParametricModel& equations, FamilyInfo& info);

}  // namespace samara::models
