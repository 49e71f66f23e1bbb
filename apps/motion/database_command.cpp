#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/motion/database/database_file.h"
#include "samara/motion/database/database_report.h"
#include "samara/motion/sweeps/sweep_file.h"
#include "terminal/interrupts.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

struct DatabaseArguments {
  std::string sweep;
  std::string output;
  bool json = false;
};

int run_database(const DatabaseArguments& arguments) {
  catch_interrupts();
  check_file_output(arguments.output, {arguments.sweep});
  check_replaced_hdf5(arguments.output, "database of motions", "samara-motions");
  const motion::Sweep sweep = motion::load_sweep(arguments.sweep);
  motion::MotionDatabase database;
  try {
    database = motion::build_database(sweep, {.progress = progress_line()});
  } catch (const NoResultError& error) {
    if (!is_interrupted()) throw;
    clear_progress();
    warn(error.what());
    return kInterrupted;
  } catch (const ArgumentError& error) {
    throw InputError(arguments.sweep, error.what());
  }
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

}  // namespace

void add_database(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<DatabaseArguments>();
  CLI::App* command = app.add_subcommand(
      "database",
      "the falls of a sweep as segments to go on from: what can follow what, and how often it does");
  command->add_option("SWEEP", values->sweep, "sweep, HDF5")->required();
  command->add_option("-o,--output", values->output, "database of motions to write, HDF5")->required();
  command->add_flag("--json", values->json, kJson);
  on_call(*command, arguments, values, run_database);
}

}  // namespace samara::apps
