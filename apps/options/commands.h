#pragma once

#include <string>

#include "options/arguments.h"

namespace CLI {
class App;
}

/// The subcommands, a file each, which holds the options and what is done with them.
namespace samara::apps {

/// All of them, in the order of the help.
void add_commands(CLI::App& app, Arguments& arguments);

/// Of `completion --names`: what may be --set of a model, a codebook or a plan.
/// @returns the exit code
int print_names(const std::string& source);

}  // namespace samara::apps
