#pragma once

#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/models/interface/parametric_model.h"

/// Internal to codebooks/: what a codebook says of what it stands for.
namespace samara::codebooks {

ModelDescription describe(const models::ParametricModel& model);

/// Of a plan of a command: its call stands for the equations.
ModelDescription describe(const Plan& plan);

}  // namespace samara::codebooks
