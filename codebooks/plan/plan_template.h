#pragma once

#include <string>

#include "samara/models/fields/field_model.h"
#include "samara/models/interface/model.h"

namespace samara::codebooks {

/// A plan to begin with: what the model needs with values to put one's own in place of, one coefficient free, and
/// what else could be said as comments. It is a plan as it stands.
/// @param name of the model, or of its file
std::string plan_template(const models::Model& model, const std::string& name);
std::string plan_template(const models::FieldModel& field);

}  // namespace samara::codebooks
