#pragma once

#include <CLI/CLI.hpp>

#include "options/arguments.h"

namespace samara::apps {

/// sweep, patterns, regime.
void add_motion_commands(CLI::App& app, Arguments& arguments);

}  // namespace samara::apps
