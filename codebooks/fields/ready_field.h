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

/// Over time, place and the box of the plan, weak in space, collocated in time and parameters; the beginning by the
/// lift. It is that of the field less its steady part: what add_steady_part() adds.
/// @param plan of a field
/// @param aim error, relative to the range of the field, that its nodes are chosen for; axes that the plan
/// prescribes stay as they are
pgd::ParametricProblem ready_problem(const Plan& plan, double aim);

/// Adds the straight line between the ends to the lift, which needs no solving: in the equations it would leave
/// rounding alone, of the size of the ends, however small what changes is.
/// @param problem ready_problem() of the same plan
void add_steady_part(const Plan& plan, pgd::ParametricProblem& problem);

/// The exact solution of a model. @param free names of the parameters that are coordinates, in their order
/// @throws ArgumentError if a parameter is neither free nor fixed and has no default, or a free one is unknown
FieldReference exact_reference(const models::FieldModel& model, const std::map<std::string, double>& fixed,
                               const std::vector<std::string>& free);

/// What a codebook of a ready field is certified against.
/// @throws ArgumentError for any other codebook, and if it lacks a parameter
FieldReference exact_reference(const Codebook& book);

}  // namespace samara::codebooks
