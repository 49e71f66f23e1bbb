#pragma once

#include <string>

#include "options/arguments.h"
#include "samara/codebooks/plan/plan.h"
#include "terminal/output.h"

namespace samara::apps {

/// The plan of a build, with what the call puts in its place: --set, --tolerance, --threads.
/// @throws InputError for the plan as it stands, ArgumentError for what is put in its place
codebooks::Plan plan_of(const BuildArguments& arguments);

/// What would be built.
Json planned_json(const codebooks::Plan& plan);
std::string planned_text(const codebooks::Plan& plan);

}  // namespace samara::apps
