#include <fmt/format.h>

#include "options/commands.h"
#include "samara/motion/database/database_file.h"
#include "samara/motion/database/database_report.h"
#include "samara/motion/sweeps/sweep_file.h"
#include "terminal/interrupts.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

int run(const DatabaseArguments& arguments) {
  catch_interrupts();
  check_output(arguments.output, {arguments.sweep});
  const motion::Sweep sweep = motion::load_sweep(arguments.sweep);
  const motion::MotionDatabase database = motion::build_database(sweep, {.progress = progress_line()});
  clear_progress();
  const motion::MotionGraph graph = motion::motion_graph(database);
  save(database, graph, arguments.output);
  narrate(fmt::format("cut {} falls into {} segments: {}", database.runs.size(), database.segment_count(),
                      arguments.output));
  const motion::KindChain kinds = motion::kind_chain(database);
  print(arguments.json ? motion::database_json(database, graph, kinds)
                       : motion::database_text(database, graph, kinds));
  return kDone;
}

}  // namespace samara::apps
