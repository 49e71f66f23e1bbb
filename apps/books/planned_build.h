#pragma once

#include <string>
#include <vector>

#include "samara/codebooks/plan/plan.h"
#include "terminal/output.h"

namespace samara::apps {

/// What was typed after `samara build`.
struct BuildArguments {
  std::string plan;
  std::string output;  ///< empty: only with dry_run
  std::vector<std::string> set;
  std::string tolerance, threads;  ///< empty: those of the plan
  bool dry_run = false;
  bool resume = false;
  bool fresh = false;
  bool force = false;
  bool json = false;
};

/// The plan of a build, with what the call puts in its place: --set, --tolerance, --threads.
/// @throws InputError for the plan as it stands, ArgumentError for what is put in its place
codebooks::Plan plan_of(const BuildArguments& arguments);

/// What would be built.
Json planned_json(const codebooks::Plan& plan);
std::string planned_text(const codebooks::Plan& plan);

}  // namespace samara::apps
