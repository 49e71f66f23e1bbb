#pragma once

#include <string>
#include <vector>

#include "samara/identification/trajectory_source.h"
#include "samara/models/model.h"

/// Internal to identification/.
namespace samara::identification {

/// The outputs that a "translation of ..." among the model's symmetries shifts.
std::vector<std::string> translated_outputs(const models::ModelInfo& model,
                                            const std::vector<FitOutput>& outputs);

/// The four outputs that hold the model's attitude quaternion (w, x, y, z), if all are there; else none.
std::vector<std::string> attitude_outputs(const models::ModelInfo& model,
                                          const std::vector<FitOutput>& outputs);

}  // namespace samara::identification
