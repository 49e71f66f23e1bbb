#include <memory>
#include <span>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "inputs/assignments.h"
#include "inputs/capture_inputs.h"
#include "models/model_with_series.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/io/csv.h"
#include "samara/motion/ghost/ghost_force.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

struct GhostArguments {
  std::string model;
  std::string path;              ///< table of poses
  std::vector<std::string> set;  ///< values of the model
  std::string coefficients;      ///< course that the motion declares, a file; empty: none
  std::vector<std::string> box;  ///< ranges of coefficients
  std::string output;            ///< sizes frame by frame; empty: none
  bool json = false;
};

motion::PosePath path_of_file(const std::string& file) {
  const std::vector<identification::Capture> captures = identification::read_captures(file);
  if (captures.size() != 1) {
    throw InputError(file, fmt::format("holds {} motions, expected one", captures.size()));
  }
  return motion::path_of(captures.front());
}

motion::GhostOptions box_of(const GhostArguments& arguments,
                            const std::map<std::string, std::string>& units) {
  motion::GhostOptions options;
  for (const std::string& text : arguments.box) {
    const Setting setting = setting_of("--box", text);
    const auto unit = units.find(setting.name);
    if (unit == units.end()) {
      throw ArgumentError(fmt::format("--box: the model has no parameter \"{}\"", setting.name));
    }
    const models::Interval range = interval_of(setting.name, setting.text, unit->second);
    options.box[setting.name] = {range.lower, range.upper};
  }
  return options;
}

std::string line_of(const char* what, const motion::GhostSizes& sizes) {
  return fmt::format("{:<18}{:>10.3g} {:>10.3g} {:>10.3g} {:>10.3g}\n", what, sizes.rms, sizes.median,
                     sizes.quantile90, sizes.max);
}

std::string text_of(const motion::GhostForce& ghost, const models::ForceUnits& units,
                    const std::string& length) {
  std::string text = fmt::format(
      "{} frames, {} minima of speed; forces in net weights of {:.4g} {}, torques in these times {:.4g}\n"
      "{:<18}{:>10} {:>10} {:>10} {:>10}\n",
      ghost.times.size(), ghost.events, ghost.net_weight, units.force, ghost.semi_length, "", "rms", "median",
      "90 %", "max");
  text += line_of("force", ghost.declared.force_sizes) + line_of("torque", ghost.declared.torque_sizes);
  if (ghost.noise) {
    text += fmt::format(
        "noise of a frame {:.2g} {}, {:.2g} rad: by itself a force of {:.3g} rms, a torque of {:.3g}\n",
        ghost.noise->frames.position, length, ghost.noise->frames.angle, ghost.noise->force,
        ghost.noise->torque);
  }
  if (!ghost.box) return text;
  text += line_of("force in the box", ghost.box->ghost.force_sizes) +
          line_of("torque in the box", ghost.box->ghost.torque_sizes);
  return text +
         fmt::format("travel of the best coefficients: {:.3g} of their ranges from minimum to minimum\n",
                     ghost.box->travel);
}

Json json_of(const motion::GhostSizes& sizes) {
  return {{"rms", sizes.rms}, {"median", sizes.median}, {"quantile90", sizes.quantile90}, {"max", sizes.max}};
}

Json json_of(const motion::GhostForce& ghost) {
  Json object = {{"schema", "samara-ghost/1"},
                 {"frames", ghost.times.size()},
                 {"events", ghost.events},
                 {"net_weight", ghost.net_weight},
                 {"semi_length", ghost.semi_length},
                 {"force", json_of(ghost.declared.force_sizes)},
                 {"torque", json_of(ghost.declared.torque_sizes)}};
  if (ghost.noise) {
    object["noise"] = {{"position", ghost.noise->frames.position},
                       {"angle", ghost.noise->frames.angle},
                       {"force", ghost.noise->force},
                       {"torque", ghost.noise->torque},
                       {"decides", ghost.noise->decides}};
  }
  if (ghost.box) {
    object["box"] = {{"coefficients", ghost.box->names},
                     {"force", json_of(ghost.box->ghost.force_sizes)},
                     {"torque", json_of(ghost.box->ghost.torque_sizes)},
                     {"travel", ghost.box->travel}};
  }
  return object;
}

std::string table_of(const motion::GhostForce& ghost) {
  std::vector<std::string> header = {"t", "force", "torque"};
  const Eigen::Index columns = ghost.box ? 5 + ghost.box->coefficients.cols() : 3;
  Eigen::MatrixXd rows(ghost.times.size(), columns);
  rows.leftCols(3) << ghost.times, ghost.declared.force, ghost.declared.torque;
  if (ghost.box) {
    header.insert(header.end(), {"force_in_box", "torque_in_box"});
    header.insert(header.end(), ghost.box->names.begin(), ghost.box->names.end());
    rows.rightCols(columns - 3) << ghost.box->ghost.force, ghost.box->ghost.torque, ghost.box->coefficients;
  }
  return io::format_csv(header, rows);
}

int run_ghost(const GhostArguments& arguments) {
  if (!arguments.output.empty()) {
    std::vector<std::string> inputs = files_of_captures(std::span(&arguments.path, 1));
    inputs.insert(inputs.end(), {arguments.model, arguments.coefficients});
    check_text_output(arguments.output, inputs, ".csv");
  }
  const auto model = codebooks::open_model(arguments.model);
  std::map<std::string, std::string> units, parameter_units;
  for (const auto& parameter : model->info().parameters) units[parameter.name] = parameter.unit;
  parameter_units = units;
  for (const auto& state : model->info().states) units[state.name + "(0)"] = state.unit;
  ModelWithSeries steered{.book = nullptr, .model = model, .values = parse_assignments(arguments.set, units)};
  if (!arguments.coefficients.empty()) {
    steered = model_with_series(arguments.coefficients, model, steered.values);
    warn_of_missed_tolerance(*steered.book, arguments.coefficients);
  }
  require_parameters(arguments.model, model->info(), steered.values);
  const models::ParametricModel parametric(steered.model, steered.values, {});
  parametric.check({});
  warn_of_parameters(*model, parametric.fixed());
  const motion::GhostForce ghost =
      ghost_force(parametric, path_of_file(arguments.path), box_of(arguments, parameter_units));
  if (!arguments.output.empty()) write_answer(arguments.output, table_of(ghost));
  if (ghost.noise && ghost.noise->decides) {
    warn(fmt::format(
        "the force is hardly more than what the noise of the frames gives by itself, {:.3g} against {:.3g} "
        "net weights rms: it says nothing of forces that are not there",
        ghost.declared.force_sizes.rms, ghost.noise->force));
  }
  if (arguments.json) {
    print(json_of(ghost));
  } else {
    print(text_of(ghost, models::force_units(model->info()), units.at("x(0)")));
  }
  return kDone;
}

}  // namespace

void add_ghost(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<GhostArguments>();
  CLI::App* command = app.add_subcommand(
      "ghost", "the invisible force of a motion: what a body would need besides all that its model knows");
  command->add_option("MODEL", values->model, "name of a model of a falling body, or a file")->required();
  command->add_option("PATH", values->path, "poses at frames: a table (as simulate writes it), or a sidecar")
      ->required();
  command->add_option("--set", values->set, "NAME=VALUE, SI or with a unit; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--coefficients", values->coefficients,
                      "course of coefficients that the motion was made with (a codebook over time)");
  command
      ->add_option("--box", values->box,
                   "NAME=FROM..TO, a coefficient that may be what hides the force best; may be repeated")
      ->allow_extra_args(false);
  command->add_option("-o,--output", values->output, "sizes of force and torque frame by frame, CSV");
  command->add_flag("--json", values->json, "print one JSON object");
  on_call(*command, arguments, values, run_ghost);
}

}  // namespace samara::apps
