#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "flow/flow_output.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/flow/books/energy_book.h"
#include "samara/flow/books/field_book.h"
#include "samara/flow/books/planned_flow.h"
#include "samara/flow/files/flow_file.h"
#include "samara/flow/files/flow_plan.h"
#include "samara/flow/march/flow_checkpoint.h"
#include "samara/io/file_lock.h"
#include "samara/models/bodies/mesh_file.h"
#include "terminal/interrupts.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

namespace fs = std::filesystem;

struct FlowArguments {
  std::string plan;
  std::string output;
  bool resume = false;
  bool fresh = false;
  bool json = false;
};

/// A run may take hours: that its result cannot be written should be known before, and no other file is lost to it.
void check_flow_target(const FlowArguments& arguments) {
  check_file_output(arguments.output, {arguments.plan});
  std::error_code ignored;
  if (!fs::is_regular_file(arguments.output, ignored)) return;
  require_readable(arguments.output);
  if (!flow::is_flow_file(arguments.output) && !codebooks::is_codebook(arguments.output))
    throw ArgumentError(
        fmt::format("the output \"{}\" is a file, and neither a flow nor a codebook: it would be lost",
                    arguments.output));
}

/// A flow and a book of flows keep theirs under the same name.
constexpr codebooks::CheckpointKind kOfFlowOrBook = {
    "a flow or a book of flows",
    [](const fs::path& file) { return flow::is_flow_checkpoint(file) || codebooks::is_journal(file); }};

/// What an earlier run with the same output has left.
/// @throws ArgumentError if the user insists on it, and there is nothing
fs::path checkpoint_of(const FlowArguments& arguments) {
  const fs::path checkpoint = arguments.output + ".checkpoint";
  std::error_code ignored;
  if (arguments.resume && !fs::exists(checkpoint, ignored))
    throw ArgumentError(fmt::format("--resume: there is no {} to go on from", checkpoint.string()));
  return checkpoint;
}

int end_interrupted_flow(const fs::path& checkpoint) {
  warn(codebooks::is_checkpoint(checkpoint)
           ? fmt::format("interrupted; {} is kept: the same line goes on from there", checkpoint.string())
           : std::string("interrupted, and nothing is kept"));
  return kInterrupted;
}

/// What an earlier run has left is taken up, unless the user wants to begin anew.
flow::FlowOptions flow_options(const FlowArguments& arguments, const flow::FlowPlan& plan) {
  flow::FlowOptions options;
  options.end = plan.end;
  options.max_time = plan.max_time;
  options.max_memory = plan.max_memory;
  options.seed = plan.seed;
  options.threads = plan.threads;
  options.checkpoint = checkpoint_of(arguments);
  options.resume = !arguments.fresh;
  if (arguments.fresh) codebooks::remove_checkpoint(options.checkpoint, kOfFlowOrBook);
  options.progress = progress_line();
  options.warning = [](const std::string& sentence) { warn(sentence); };
  return options;
}

/// Of a box as a whole. @throws InputError with the place of the box
void check_book(const FlowArguments& arguments, const flow::FlowPlan& plan) {
  try {
    flow::check_book(plan);
  } catch (const ArgumentError& error) {
    throw InputError(arguments.plan, plan.box_line, fmt::format("box: {}", error.what()));
  }
}

int build_book(const FlowArguments& arguments, const flow::FlowPlan& plan) {
  codebooks::BuildOptions options;
  options.checkpoint = checkpoint_of(arguments);
  options.keep_checkpoint = true;
  options.resume = !arguments.fresh;
  options.progress = progress_line();
  options.warning = [](const std::string& sentence) { warn(sentence); };
  std::error_code ignored;
  const auto forget_flows = [&] {
    fs::remove(options.checkpoint, ignored);
    fs::remove(flow::finer_checkpoint(options.checkpoint), ignored);
  };
  check_book(arguments, plan);  // no plan that is refused takes hours of another with it
  codebooks::check_checkpoint_path(options.checkpoint,
                                   arguments.fresh ? kOfFlowOrBook : codebooks::kJournalKind);
  codebooks::check_checkpoint_path(flow::finer_checkpoint(options.checkpoint));
  if (arguments.fresh || !codebooks::is_checkpoint(options.checkpoint)) forget_flows();
  try {
    const codebooks::BuildResult result =
        plan.of_fields ? flow::build_field_book(plan, options) : flow::build_energy_book(plan, options);
    if (is_interrupted()) return end_interrupted_flow(options.checkpoint);
    codebooks::save(result.book, arguments.output);
    if (!arguments.json) print(to_table(*result.book.certificate(), result.book));
    const Eigen::VectorXd change = plan.of_fields ? flow::field_discretisation(plan, result.book, options)
                                                  : flow::discretisation(plan, result.book, options);
    clear_progress();
    codebooks::save(flow::with_discretisation(result.book, change), arguments.output);
    std::string text = fmt::format(
        "twice the cells, at both ends of the box, change by these shares of the range between them{}:\n",
        plan.of_fields ? ", in root mean square over the places" : "");
    for (Eigen::Index o = 0; o < change.size(); ++o)
      text += fmt::format("  {:<14} {:.3g}\n", result.book.outputs()[static_cast<std::size_t>(o)].name,
                          change(o));
    if (arguments.json) {
      Json object = {{"schema", "samara-flow-book/1"},
                     {"output", arguments.output},
                     {"met", result.met},
                     {"discretisation", Json::object()}};
      for (Eigen::Index o = 0; o < change.size(); ++o)
        object["discretisation"][result.book.outputs()[static_cast<std::size_t>(o)].name] = change(o);
      object["certificate"] = to_json(*result.book.certificate(), result.book);
      print(object);
    } else {
      print(text);
    }
    if (!result.resumable) forget_flows();
    if (result.met) return kDone;
    warn(fmt::format("{} is written and marked: {}", arguments.output, result.message));
    return kToleranceMissed;
  } catch (const NoResultError&) {
    if (is_interrupted()) return end_interrupted_flow(options.checkpoint);
    throw;
  }
}

int run_flow(const FlowArguments& arguments) {
  catch_interrupts();
  check_flow_target(arguments);
  const flow::FlowPlan plan = flow::read_flow_plan(
      arguments.plan, [](const std::string& path) { return models::read_mesh(path, 1.0); });
  const io::FileLock lock(arguments.output + ".lock", fmt::format("computes {}", arguments.output));
  if (!plan.box.empty()) {
    if (flow::is_flow_file(arguments.output))
      throw ArgumentError(
          fmt::format("the output \"{}\" is a flow, and a codebook would be written: it would be lost",
                      arguments.output));
    return build_book(arguments, plan);
  }
  std::error_code ignored;
  if (fs::is_regular_file(arguments.output, ignored) && !flow::is_flow_file(arguments.output))
    throw ArgumentError(fmt::format(
        "the output \"{}\" is a codebook, and a flow would be written: it would be lost", arguments.output));
  const flow::FlowOptions options = flow_options(arguments, plan);
  const flow::FlowResult result = flow::solve_flow(plan.flow, options);
  clear_progress();
  for (const std::string& warning : result.warnings) warn(warning);
  if (result.status == flow::FlowStatus::cancelled) return end_interrupted_flow(options.checkpoint);
  if (result.status == flow::FlowStatus::diverged) {
    const bool kept = fs::exists(options.checkpoint, ignored);
    throw NoResultError(fmt::format(
        "the flow diverged: {}; no file is written{}", result.message,
        kept ? fmt::format(", and {} keeps the state of at most a minute before", options.checkpoint.string())
             : std::string()));
  }
  flow::save_flow(result, plan, arguments.output);
  const flow::StoredFlow stored = flow::load_flow(arguments.output);
  print(arguments.json ? json_line(to_json(stored)) : to_table(stored, arguments.output));
  if (result.status != flow::FlowStatus::max_time) {
    fs::remove(options.checkpoint, ignored);
    return kDone;
  }
  std::string kept;
  if (codebooks::is_checkpoint(options.checkpoint))
    kept = fmt::format("; {} is kept: the same line with a larger max_time goes on from there",
                       options.checkpoint.string());
  warn(fmt::format("{} is written and marked: {}{}", arguments.output, result.message, kept));
  return kToleranceMissed;
}

}  // namespace

void add_flow(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<FlowArguments>();
  CLI::App* command = app.add_subcommand(
      "flow", "the flow about a body that is held in a stream, of a plan, with its turbulence");
  command->add_option("PLAN", values->plan, "plan with a table [flow], TOML")->required();
  command->add_option("-o,--output", values->output, "flow file to write, HDF5")->required();
  CLI::Option* resume = command->add_flag(
      "--resume", values->resume,
      "only go on where a run of the same plan and output stopped, which is done anyway if there is one");
  command->add_flag("--fresh", values->fresh, "begin anew, and drop what an earlier run has left")
      ->excludes(resume);
  command->add_flag("--json", values->json, kJson);
  on_call(*command, arguments, values, run_flow);
}

}  // namespace samara::apps
