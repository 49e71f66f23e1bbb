#pragma once

#include <CLI/CLI.hpp>

#include "options/arguments.h"

namespace samara::apps {

/// ghost, synthesize.
void add_planning_commands(CLI::App& app, Arguments& arguments);

}  // namespace samara::apps
