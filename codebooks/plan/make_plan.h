#pragma once

#include "samara/codebooks/plan/plan.h"

namespace samara::codebooks {

/// The plan that asks this of a model whose free coordinates have the intervals of the box.
/// @throws ArgumentError if a free coordinate has no entry in the box, or for what read_plan() refuses
Plan make_plan(const models::ParametricModel& model, const BuildRequest& request);

}  // namespace samara::codebooks
