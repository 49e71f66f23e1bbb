#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/option_parts.h"
#include "pictures/animation.h"
#include "pictures/shown_bodies.h"
#include "samara/base/errors.h"
#include "samara/base/text.h"
#include "samara/codebooks/file/file_format.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/identification/series/series_codebook.h"
#include "samara/io/animated_scene.h"
#include "samara/io/atomic_file.h"
#include "samara/io/csv.h"
#include "samara/io/file_lock.h"
#include "samara/motion/ghost/ghost_force.h"
#include "samara/motion/pages/motion_page.h"
#include "samara/motion/planning/motion_picture.h"
#include "samara/motion/planning/planner.h"
#include "samara/motion/planning/planning_state.h"
#include "terminal/interrupts.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

struct SynthesizeArguments {
  std::string plan;
  std::string output;   ///< the motion
  std::string course;   ///< its coefficients, a file; empty: none
  std::string csv;      ///< its states; empty: none
  std::string picture;  ///< of path and coefficients; empty: none
  std::string report;   ///< page for the browser; empty: none
  bool resume = false;  ///< only go on from what an interrupted search has left
  bool fresh = false;   ///< begin anew
  ShownWords body;
  bool json = false;
};

void check_outputs(const SynthesizeArguments& arguments, const std::vector<std::string>& inputs) {
  const bool is_csv = ending_of(arguments.output) == ".csv";
  if (!is_csv && !io::is_scene_name(arguments.output)) {
    throw ArgumentError(
        fmt::format("-o is \"{}\", expected a name that ends in .glb, .usda or .csv", arguments.output));
  }
  if (is_csv) refuse_shown(arguments.body);
  const std::vector<std::pair<std::string, std::string>> written = {{"--output", arguments.output},
                                                                    {"--course", arguments.course},
                                                                    {"--csv", arguments.csv},
                                                                    {"--picture", arguments.picture},
                                                                    {"--report", arguments.report}};
  for (const auto& [option, path] : written) {
    if (path.empty()) continue;
    if (option == "--course") {
      check_file_output(path, inputs);
      check_replaced_hdf5(path, "codebook", codebooks::format::kFormat);
    } else if (option == "--csv") {
      check_text_output(path, inputs, ".csv");
    } else {
      check_output(path, inputs);
    }
  }
  check_outputs_differ(written);
  check_ending("--picture", arguments.picture, ".svg");
  check_ending("--report", arguments.report, ".html");
}

std::string states_csv(const motion::MotionPlan& plan, const motion::MotionResult& motion) {
  const models::ModelInfo& info = plan.model->info();
  std::vector<std::string> header = {fmt::format("t[{}]", models::time_unit(info))};
  for (const models::StateInfo& state : info.states)
    header.push_back(fmt::format("{}[{}]", state.name, state.unit));
  Eigen::MatrixXd rows(motion.times.size(), 1 + motion.states.cols());
  rows << motion.times, motion.states;
  return io::format_csv(header, rows);
}

/// What the body is without the coefficients that the course gives.
std::map<std::string, double> others(const motion::MotionPlan& plan) {
  std::map<std::string, double> fixed = plan.fixed;
  for (const motion::SteeredCoefficient& coefficient : plan.box) fixed.erase(coefficient.name);
  return fixed;
}

/// What a .glb or .usda shows; nothing of another output.
Animation animation_of(const SynthesizeArguments& arguments, const motion::MotionPlan& plan) {
  if (!io::is_scene_name(arguments.output)) return {};
  const models::ModelInfo& info = plan.model->info();
  return {.states = animated_states(info),
          .body = animated_body(arguments.body, models::ParametricModel(plan.model, plan.fixed, {}), {}),
          .model = info.name,
          .parameters = plan.fixed,
          .notes = {{"plan", plan.text}, {"seed", std::to_string(plan.search.seed)}}};
}

/// The motion itself: integrated again, a long one would be another.
void write_motion(const SynthesizeArguments& arguments, const motion::MotionPlan& plan,
                  const motion::MotionResult& motion, const Animation& animation) {
  if (!io::is_scene_name(arguments.output))
    return io::write_text_atomically(arguments.output, states_csv(plan, motion));
  write_animation(arguments.output, animation, plan.model->info(), motion.times, motion.states);
}

/// Where an interrupted search is kept. @throws ArgumentError for --resume without any
motion::PlanningOptions planning_options(const SynthesizeArguments& arguments) {
  motion::PlanningOptions options{.progress = progress_line(),
                                  .checkpoint = arguments.output + ".part",
                                  .keep_checkpoint = true,
                                  .warning = [](const std::string& sentence) { warn(sentence); }};
  std::error_code ignored;
  const bool is_there = std::filesystem::exists(options.checkpoint, ignored);
  if (arguments.resume && !is_there)
    throw ArgumentError(fmt::format("--resume: there is no {} to go on from", options.checkpoint.string()));
  if (arguments.fresh) codebooks::remove_checkpoint(options.checkpoint, motion::kPlanningCheckpoint);
  return options;
}

int end_interrupted_search(const motion::PlanningOptions& options, const std::string& message) {
  std::error_code ignored;
  warn(std::filesystem::exists(options.checkpoint, ignored)
           ? fmt::format("{}; {} is kept: the same line goes on from there", message,
                         options.checkpoint.string())
           : message);
  return kInterrupted;
}

int run_synthesize(const SynthesizeArguments& arguments) {
  catch_interrupts();
  check_outputs(arguments, {arguments.plan});
  const motion::MotionPlan plan = motion::read_motion_plan(arguments.plan);
  check_outputs(arguments, plan.files);
  warn_of_parameters(*plan.model, plan.fixed);
  const io::FileLock lock(arguments.output + ".lock", fmt::format("synthesizes {}", arguments.output));
  const Animation animation = animation_of(arguments, plan);
  const motion::PlanningOptions options = planning_options(arguments);
  const motion::MotionResult motion = plan_motion(plan, options);
  clear_progress();
  if (motion.status == motion::MotionStatus::cancelled)
    return end_interrupted_search(options, motion.message);
  const auto forget_search = [&] {
    std::error_code ignored;
    std::filesystem::remove(options.checkpoint, ignored);
  };
  // The same search would end there again.
  if (!motion.is_usable() || motion.times.size() < motion::kFewestPoses) forget_search();
  if (!motion.is_usable()) throw NoResultError(motion.message);
  if (motion.times.size() < motion::kFewestPoses)
    throw NoResultError(
        fmt::format("the fall is over after {} steps, expected {} or more: give a smaller step in "
                    "[search]",
                    motion.times.size() - 1, motion::kFewestPoses - 1));
  const codebooks::Codebook book =
      course_codebook(*motion.course, plan.model->info(), others(plan), motion.end);
  if (!arguments.course.empty()) codebooks::save(book, arguments.course);
  if (!arguments.csv.empty()) io::write_text_atomically(arguments.csv, states_csv(plan, motion));
  write_motion(arguments, plan, motion, animation);
  const models::ParametricModel declared(
      models::following(plan.model, identification::codebook_course(book, plan.model->info())), others(plan),
      {});
  const motion::GhostForce ghost =
      ghost_force(declared, motion::path_of(plan.model->info(), motion.times, motion.states));
  if (!arguments.picture.empty())
    io::write_text_atomically(arguments.picture, motion::motion_picture(plan, motion, ghost));
  if (!arguments.report.empty())
    io::write_text_atomically(arguments.report, motion::motion_html(plan, motion, ghost));
  forget_search();
  if (arguments.json) {
    print(motion::motion_json(plan, motion, ghost));
  } else {
    print(fmt::format(
        "{}: {}\non the way {:.4g}, {} knots; invisible force at most {:.2g} net weights, torque {:.2g}\n"
        "who replays the course by CVODES stays within a tenth of a semi-length up to {:.4g}\n",
        to_string(motion.status), motion.message, motion.end, motion.course->knots().size(),
        ghost.declared.force_sizes.max, ghost.declared.torque_sizes.max, motion.replayed_until));
    if (motion.book)
      print(fmt::format("the codebook gave tangents of {:.0f} % of what was refined, in {} windows\n",
                        100.0 * motion.book->share(), motion.book->windows));
  }
  if (motion.status == motion::MotionStatus::found) return kDone;
  warn(fmt::format("{}: the motion is written all the same", motion.message));
  return kToleranceMissed;
}

}  // namespace

void add_synthesize(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<SynthesizeArguments>();
  CLI::App* command = app.add_subcommand("synthesize",
                                         "a fall that follows a sketch, comes down at a place, or swings and "
                                         "turns in a given order, by coefficients "
                                         "that change on the way");
  command->add_option("PLAN", values->plan, "what the fall is to do, TOML")->required();
  command->add_option("-o,--output", values->output, "motion to write: .glb, .usda, or .csv of states")
      ->required();
  command->add_option("--course", values->course,
                      "its coefficients over time to write, HDF5: what simulate --coefficients replays");
  command->add_option("--csv", values->csv, "its states to write");
  command->add_option("--picture", values->picture,
                      "path over the sketch, coefficients, invisible force: SVG to write");
  command->add_option(
      "--report", values->report,
      "page for the browser to write: path, coefficients, kinds asked and got, invisible force");
  CLI::Option* resume = command->add_flag(
      "--resume", values->resume,
      "only go on where a search of the same plan and output stopped, which is done anyway if there is one");
  command->add_flag("--fresh", values->fresh, "begin anew, and drop what an earlier search has left")
      ->excludes(resume);
  add_shown_words(*command, values->body);
  command->add_flag("--json", values->json, "print one JSON object");
  on_call(*command, arguments, values, run_synthesize);
}

}  // namespace samara::apps
