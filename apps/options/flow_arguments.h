#pragma once

#include "options/arguments.h"

namespace CLI {
class App;
}

namespace samara::apps {

/// The commands `flow` and `picture`.
void add_flow(CLI::App& app, Arguments& arguments);
void add_picture(CLI::App& app, Arguments& arguments);

}  // namespace samara::apps
