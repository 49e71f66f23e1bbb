#include "options/commands.h"

// In the order of the help, one line each: <name>_command.cpp in one of the folders defines add_<name>(), which gives
// the parser the command and its options, and by on_call() of option_parts.h says what is run.
#define SAMARA_COMMANDS(COMMAND) \
  COMMAND(models)                \
  COMMAND(simulate)              \
  COMMAND(plan)                  \
  COMMAND(build)                 \
  COMMAND(info)                  \
  COMMAND(stats)                 \
  COMMAND(query)                 \
  COMMAND(export)                \
  COMMAND(explore)               \
  COMMAND(plot)                  \
  COMMAND(validate)              \
  COMMAND(fit)                   \
  COMMAND(body)                  \
  COMMAND(design)                \
  COMMAND(compare)               \
  COMMAND(follow)                \
  COMMAND(wind)                  \
  COMMAND(flow)                  \
  COMMAND(picture)               \
  COMMAND(sweep)                 \
  COMMAND(database)              \
  COMMAND(patterns)              \
  COMMAND(regime)                \
  COMMAND(ghost)                 \
  COMMAND(synthesize)

namespace samara::apps {

#define SAMARA_DECLARE(name) void add_##name(CLI::App& app, Arguments& arguments);
SAMARA_COMMANDS(SAMARA_DECLARE)
#undef SAMARA_DECLARE

void add_commands(CLI::App& app, Arguments& arguments) {
#define SAMARA_CALL(name) add_##name(app, arguments);
  SAMARA_COMMANDS(SAMARA_CALL)
#undef SAMARA_CALL
}

}  // namespace samara::apps
