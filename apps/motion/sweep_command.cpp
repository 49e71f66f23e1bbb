#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "motion/motion_answers.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/io/file_lock.h"
#include "samara/motion/sweeps/refining.h"
#include "samara/motion/sweeps/sweep_checkpoint.h"
#include "samara/motion/sweeps/sweep_file.h"
#include "terminal/interrupts.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

struct SweepArguments {
  std::string plan;
  std::string output;
  bool resume = false;
  bool fresh = false;
  bool json = false;
};

void check_sweep_target(const SweepArguments& arguments) {
  check_file_output(arguments.output, {arguments.plan});
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(arguments.output, ignored)) return;
  require_readable(arguments.output);
  if (!motion::is_sweep(arguments.output))
    throw ArgumentError(fmt::format("the output \"{}\" is a file, and no sweep", arguments.output));
}

motion::SweepOptions sweep_options(const SweepArguments& arguments) {
  motion::SweepOptions options;
  options.checkpoint = arguments.output + ".part";
  options.keep_checkpoint = true;
  options.progress = progress_line();
  options.warning = [](const std::string& sentence) { warn(sentence); };
  std::error_code ignored;
  const bool is_there = std::filesystem::exists(options.checkpoint, ignored);
  if (arguments.resume && !is_there)
    throw ArgumentError(fmt::format("--resume: there is no {} to go on from", options.checkpoint.string()));
  if (arguments.fresh) codebooks::remove_checkpoint(options.checkpoint, motion::kSweepCheckpoint);
  return options;
}

int end_interrupted_sweep(const motion::SweepOptions& options, const std::string& message) {
  std::error_code ignored;
  warn(std::filesystem::exists(options.checkpoint, ignored)
           ? fmt::format("{}; {} is kept: the same line goes on from there", message,
                         options.checkpoint.string())
           : fmt::format("{}, before there was anything to keep", message));
  return kInterrupted;
}

void narrate_rounds(const motion::RefiningResult& refined) {
  for (const motion::RefiningRound& round : refined.rounds)
    narrate(fmt::format("{} points, {} of them run, tell {:.2f} % of those that came first right",
                        round.points, round.run, 100.0 * round.agreement));
  narrate("refined: " + refined.message);
}

int run_sweep(const SweepArguments& arguments) {
  catch_interrupts();
  check_sweep_target(arguments);
  const motion::SweepPlan plan = motion::read_sweep_plan(arguments.plan);
  warn_of_parameters(*plan.model, plan.fixed);
  const io::FileLock lock(arguments.output + ".lock", fmt::format("sweeps {}", arguments.output));
  const motion::SweepOptions options = sweep_options(arguments);
  motion::SweepResult result = run_sweep(plan, options);
  clear_progress();
  if (!result.complete) return end_interrupted_sweep(options, result.message);
  if (result.taken_up > 0) narrate(fmt::format("took up {} falls of an earlier sweep", result.taken_up));
  double seconds = result.seconds;
  if (plan.refine > 0) {
    const motion::RefiningResult refined = motion::refine_by_plan(plan, options, result.sweep);
    clear_progress();
    if (!refined.complete) return end_interrupted_sweep(options, "interrupted while it was refined");
    narrate_rounds(refined);
    seconds += refined.seconds;
  }
  save(result.sweep, arguments.output);
  std::error_code ignored;
  std::filesystem::remove(options.checkpoint, ignored);
  narrate(fmt::format("swept {} falls, {} of them run, in {:.2f} s: {}", result.sweep.fall_count(),
                      result.sweep.run_count(), seconds, arguments.output));
  if (arguments.json) {
    print(sweep_json(result.sweep));
  } else {
    print(sweep_counts(result.sweep));
  }
  return kDone;
}

}  // namespace

void add_sweep(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<SweepArguments>();
  CLI::App* command =
      app.add_subcommand("sweep", "the same fall at many points of a box: features and patterns");
  command->add_option("PLAN", values->plan, "what is swept, TOML")->required();
  command->add_option("-o,--output", values->output, "sweep file to write, HDF5")->required();
  CLI::Option* resume = command->add_flag(
      "--resume", values->resume,
      "only go on where a sweep of the same plan and output stopped, which is done anyway if there is one");
  command->add_flag("--fresh", values->fresh, "begin anew, and drop what an earlier sweep has left")
      ->excludes(resume);
  command->add_flag("--json", values->json, kJson);
  on_call(*command, arguments, values, run_sweep);
}

}  // namespace samara::apps
