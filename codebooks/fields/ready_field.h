#pragma once

#include <map>
#include <string>
#include <vector>

#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/certify/certify_field.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/models/fields/field_model.h"
#include "samara/pgd/linear/parametric_problem.h"

/// The fields that ship with Samara (models/fields) as linear problems over what a plan frees.
namespace samara::codebooks {

/// Over time, place and the box of the plan, weak in space, collocated in time and parameters; ends, beginning and
/// all that enters linearly by the lift.
/// @param plan of a field
/// @param aim error, relative to the range of the field, that its nodes are chosen for; axes that the plan
/// prescribes stay as they are
pgd::ParametricProblem ready_problem(const Plan& plan, double aim);

/// The exact solution of a model. @param free names of the parameters that are coordinates, in their order
FieldReference exact_reference(const models::FieldModel& model, const std::map<std::string, double>& fixed,
                               const std::vector<std::string>& free);

/// What a codebook of a ready field is certified against.
/// @throws ArgumentError for any other codebook
FieldReference exact_reference(const Codebook& book);

}  // namespace samara::codebooks
