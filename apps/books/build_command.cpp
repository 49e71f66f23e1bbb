#include <filesystem>
#include <memory>
#include <system_error>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "books/planned_build.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/io/file_lock.h"
#include "samara/io/toml_document.h"
#include "terminal/interrupts.h"
#include "terminal/output.h"
#include "terminal/terminal.h"
#include "terminal/text_layout.h"

namespace samara::apps {

namespace {

/// A build may take long: that its result cannot be written should be known before. No other file is lost to a
/// codebook.
void check_target(const BuildArguments& arguments) {
  check_file_output(arguments.output, {arguments.plan});
  std::error_code ignored;
  const bool is_file = std::filesystem::is_regular_file(arguments.output, ignored);
  if (is_file && !arguments.force) require_readable(arguments.output);
  if (is_file && !arguments.force && !codebooks::is_codebook(arguments.output))
    throw ArgumentError(
        fmt::format("the output \"{}\" is a file, and no codebook: --force replaces it", arguments.output));
}

/// The file of the body's mesh; empty without one.
std::string mesh_of(const codebooks::Plan& plan, const std::string& file) {
  const auto body = io::TomlTable::parse(plan.text, file).optional_table("body");
  if (!body || !body->has("mesh")) return {};
  return (std::filesystem::path(file).parent_path() / body->string("mesh")).string();
}

/// What an earlier build has left is taken up, unless the user wants to begin anew.
codebooks::BuildOptions build_options(const BuildArguments& arguments) {
  codebooks::BuildOptions options;
  options.checkpoint = arguments.output + ".checkpoint";
  options.keep_checkpoint = true;
  options.resume = !arguments.fresh;
  std::error_code ignored;
  const bool is_there = std::filesystem::exists(options.checkpoint, ignored);
  if (arguments.resume && !is_there)
    throw ArgumentError(fmt::format("--resume: there is no {} to go on from", options.checkpoint.string()));
  if (arguments.fresh) codebooks::remove_checkpoint(options.checkpoint);
  options.progress = [report = progress_line(), path = options.checkpoint,
                      goes_on = is_there && !arguments.fresh](const Progress& progress) mutable {
    if (goes_on)
      narrate(fmt::format("going on from {}", path.string()));  // now it is known to be of this plan
    goes_on = false;
    return report(progress);
  };
  options.warning = [](const std::string& sentence) { warn(sentence); };
  return options;
}

Json build_json(const codebooks::BuildResult& result, const std::string& path) {
  const codebooks::BuildRecord& record = result.book.build();
  return {{"schema", "samara-build/1"},
          {"output", path},
          {"met", result.met},
          {"message", result.message},
          {"builder", record.builder},
          {"strategy", record.strategy},
          {"status", to_string(record.status)},
          {"seconds", result.book.provenance().build_seconds},
          {"effort", effort(result.book)},
          {"certificate", to_json(*result.book.certificate(), result.book)}};
}

int end_interrupted(const std::filesystem::path& checkpoint) {
  std::error_code ignored;
  warn(std::filesystem::exists(checkpoint, ignored)
           ? fmt::format("interrupted; {} is kept: the same line goes on from there", checkpoint.string())
           : std::string("interrupted, before there was anything to keep"));
  return kInterrupted;
}

std::string kept_calls(const std::filesystem::path& checkpoint) {
  return fmt::format(
      "the calls that were answered are kept in {}: the same line calls for the others only, a changed plan "
      "needs --fresh",
      checkpoint.string());
}

int run_build(const BuildArguments& arguments) {
  if (arguments.dry_run) {
    const codebooks::Plan plan = plan_of(arguments);
    if (!arguments.output.empty()) check_target(arguments);
    print(arguments.json ? json_line(planned_json(plan)) : planned_text(plan));
    return kDone;
  }
  if (arguments.output.empty())
    throw ArgumentError("--output is required: -o and the codebook file to write");
  catch_interrupts();
  check_target(arguments);
  const codebooks::Plan plan = plan_of(arguments);
  check_output(arguments.output, {plan.model_file, mesh_of(plan, arguments.plan)});
  const io::FileLock lock(arguments.output + ".lock", fmt::format("builds {}", arguments.output));
  const codebooks::BuildOptions options = build_options(arguments);
  try {
    const codebooks::BuildResult result = codebooks::build(plan, options);
    if (is_interrupted()) return end_interrupted(options.checkpoint);
    codebooks::save(result.book, arguments.output);
    if (!result.resumable) {
      std::error_code ignored;
      std::filesystem::remove(options.checkpoint, ignored);
    }
    narrate(fmt::format("built {} by {} in {:.1f} s: {}", arguments.output, result.book.build().builder,
                        result.book.provenance().build_seconds, effort(result.book)));
    print(arguments.json ? json_line(build_json(result, arguments.output))
                         : wrapped_lines(to_table(*result.book.certificate(), result.book)));
    if (result.met) return kDone;
    warn(fmt::format("{} is written and marked: {}", arguments.output, result.message));
    if (result.resumable) warn(kept_calls(options.checkpoint));
    return kToleranceMissed;
  } catch (const NoResultError& error) {
    // A program that is asked for answers gets Ctrl-C too, and ends.
    if (is_interrupted()) return end_interrupted(options.checkpoint);
    // A program may be mended and go on; where a model gives no result, it never will.
    std::error_code ignored;
    if (!plan.command) std::filesystem::remove(options.checkpoint, ignored);
    if (!std::filesystem::exists(options.checkpoint, ignored)) throw;
    throw NoResultError(fmt::format("{}; {}", error.what(), kept_calls(options.checkpoint)));
  }
}

}  // namespace

void add_build(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<BuildArguments>();
  CLI::App* command = app.add_subcommand("build", "builds and certifies the codebook of a plan");
  command->add_option("PLAN", values->plan, "plan, TOML; - for stdin")->required();
  command->add_option("-o,--output", values->output,
                      "codebook file to write, HDF5; needed but for --dry-run");
  command->add_option("--set", values->set,
                      "in place of what the plan says: NAME=VALUE fixes, NAME=FROM..TO frees, SI or with a "
                      "unit: C_D=0.8..1.4");
  command->add_option("--tolerance", values->tolerance, "relative, in place of the plan's");
  command->add_option("--threads", values->threads, "in place of the plan's; 0: as many as the machine has");
  CLI::Option* dry =
      command->add_flag("--dry-run", values->dry_run, "check the plan and say what would be built, no more");
  CLI::Option* resume = command->add_flag(
      "--resume", values->resume,
      "only go on where a build of the same plan and output stopped, which is done anyway if there is one");
  resume->excludes(dry);
  command->add_flag("--fresh", values->fresh, "begin anew, and drop what an earlier build has left")
      ->excludes(resume)
      ->excludes(dry);
  command->add_flag("--force", values->force, "replace the output also if it is no codebook");
  command->add_flag("--json", values->json, kJson);
  on_call(*command, arguments, values, run_build);
}

}  // namespace samara::apps
