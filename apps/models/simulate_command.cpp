#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "air/cloud_command.h"
#include "air/winds.h"
#include "inputs/assignments.h"
#include "inputs/bodies.h"
#include "inputs/value_lists.h"
#include "models/model_with_series.h"
#include "options/option_parts.h"
#include "pictures/animation.h"
#include "samara/base/errors.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/io/animated_scene.h"
#include "samara/io/csv.h"
#include "samara/models/trajectories/integrator_trajectories.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

/// Columns of a CSV file: their header, and one row per time.
struct Table {
  std::vector<std::string> header;
  Eigen::MatrixXd rows;
};

/// Components of a term that are not zero by its kind: in the plane, or in space.
std::vector<std::string> component_names(const models::ModelInfo& info) {
  if (info.per_span) return {"Fx", "Fy", "T", "power"};
  return {"Fx", "Fy", "Fz", "Tx", "Ty", "Tz", "power"};
}

std::vector<double> components(const models::ModelInfo& info, const models::Wrench& term) {
  const Eigen::Vector3d& F = term.force;
  const Eigen::Vector3d& T = term.torque;
  if (info.per_span) return {F.x(), F.y(), T.z(), term.power};
  return {F.x(), F.y(), F.z(), T.x(), T.y(), T.z(), term.power};
}

std::vector<std::string> force_header(const models::ModelInfo& info, bool with_energy) {
  const models::ForceUnits units = models::force_units(info);
  std::vector<std::string> header;
  for (const auto& term : info.force_terms) {
    std::string name = term.name;
    std::ranges::replace(name, ' ', '_');
    for (const std::string& component : component_names(info)) {
      const std::string& unit = component[0] == 'F'   ? units.force
                                : component[0] == 'T' ? units.torque
                                                      : units.power;
      header.push_back(fmt::format("{}.{}[{}]", name, component, unit));
    }
  }
  if (with_energy) header.push_back(fmt::format("kinetic_energy[{}]", units.energy));
  return header;
}

/// What every term does along a trajectory, and the kinetic energy where the model has one.
Table force_table(const models::ParametricModel& parametric, const Eigen::VectorXd& times,
                  const Eigen::MatrixXd& states) {
  const models::Model& model = parametric.model();
  const models::ModelInfo& info = model.info();
  const models::ParameterValues p = parametric.parameter_values({});
  std::vector<models::Wrench> terms(info.force_terms.size());
  std::vector<double> x(info.states.size());
  std::vector<double> values;
  bool with_energy = false;
  for (Eigen::Index row = 0; row < times.size(); ++row) {
    const double t = times[row];
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = states(row, static_cast<Eigen::Index>(i));
    model.forces(t, x, p, terms);
    for (const models::Wrench& term : terms) {
      const std::vector<double> list = components(info, term);
      values.insert(values.end(), list.begin(), list.end());
    }
    const std::optional<double> energy = model.kinetic_energy(t, x, p);
    with_energy = energy.has_value();
    if (energy) values.push_back(*energy);
  }
  Table table = {force_header(info, with_energy), {}};
  table.rows = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      values.data(), times.size(), static_cast<Eigen::Index>(table.header.size()));
  return table;
}

/// States, then what the model derives from them.
Table output_table(const models::ModelInfo& info, const std::vector<models::FamilyOutput>& outputs,
                   const Eigen::VectorXd& times, const Eigen::MatrixXd& values) {
  Table table = {{fmt::format("t[{}]", models::time_unit(info))}, {}};
  for (const models::FamilyOutput& output : outputs)
    table.header.push_back(fmt::format("{}[{}]", output.name, output.unit));
  table.rows.resize(times.size(), 1 + values.cols());
  table.rows << times, values;
  return table;
}

/// "v[m/s]" in its name and its unit, and its numbers; null where the motion had ended.
Json trajectory_json(const std::string& model, const Table& table, const std::string& message) {
  Json object = {
      {"schema", "samara-simulate/1"}, {"model", model}, {"message", message}, {"columns", Json::array()}};
  for (std::size_t c = 0; c < table.header.size(); ++c) {
    const std::string& header = table.header[c];
    const std::size_t open = header.rfind('[');
    Json values = Json::array();
    for (const double value : table.rows.col(static_cast<Eigen::Index>(c)))
      values.push_back(std::isfinite(value) ? Json(value) : Json(nullptr));
    object["columns"].push_back({{"name", header.substr(0, open)},
                                 {"unit", header.substr(open + 1, header.size() - open - 2)},
                                 {"values", std::move(values)}});
  }
  return object;
}

Table beside(const Table& left, const Table& right) {
  Table both = left;
  both.header.insert(both.header.end(), right.header.begin(), right.header.end());
  both.rows.resize(left.rows.rows(), left.rows.cols() + right.rows.cols());
  both.rows << left.rows, right.rows;
  return both;
}

/// The last time [the model's unit of time]. Times so short that round-off exceeds them show no motion, and
/// integrators stop.
double end_of(const SimulateArguments& arguments, const models::ParametricModel& parametric) {
  const std::string unit = models::time_unit(parametric.model().info());
  const double end = positive_quantity("--until", arguments.until, unit);
  parametric.check({});
  const double least = 1e-12 * parametric.scales({}).time;
  if (end < least) {
    throw ArgumentError(
        fmt::format("--until is {}, expected at least {:.2g} {}, 1e-12 of the characteristic time of \"{}\"",
                    arguments.until, least, unit, parametric.model().info().name));
  }
  return end;
}

/// Before anything is allocated.
void check_frames(const SimulateArguments& arguments, const models::ModelInfo& info) {
  constexpr int kMostFrames = 10000000;
  if (arguments.frames < 2 || arguments.frames > kMostFrames) {
    throw ArgumentError(fmt::format("--frames is {}, expected 2 to {}", arguments.frames, kMostFrames));
  }
  // A value lies in the trajectory, in two tables, and as text in the answer.
  constexpr double kBytesPerValue = 3.0 * sizeof(double) + 24.0;
  constexpr double kMostBytes = 2e9;
  const auto columns = static_cast<double>(1 + info.states.size() + info.outputs.size() +
                                           (arguments.forces ? 7 * info.force_terms.size() + 1 : 0));
  const double most = std::floor(kMostBytes / (kBytesPerValue * columns));
  if (arguments.frames > most) {
    throw ArgumentError(
        fmt::format("--frames is {}, which would take {:.1f} GB with {} columns; expected at most {}",
                    arguments.frames, 1e-9 * kBytesPerValue * columns * arguments.frames, columns, most));
  }
}

/// What --integrator and --step say. @param gust the shortest, infinite where there is none [s]
models::IntegratorChoice integrator_of(const SimulateArguments& arguments, const models::ModelInfo& info,
                                       double gust) {
  const bool stiff = arguments.integrator == "bdf";
  const bool fixed = !stiff && arguments.integrator != "cvodes" && arguments.integrator != "adaptive";
  if (fixed && arguments.step.empty()) {
    throw ArgumentError(
        fmt::format("--integrator {} takes fixed steps: --step was expected", arguments.integrator));
  }
  if (!fixed && !arguments.step.empty()) {
    throw ArgumentError(
        fmt::format("--integrator {} chooses its steps: no --step was expected", arguments.integrator));
  }
  // A body that falls steadily takes long steps: they must not leap over a gust.
  const double longest = std::isfinite(gust) ? 0.25 * gust : 0.0;
  if (arguments.integrator == "adaptive") return models::AdaptiveOptions{.max_step = longest};
  if (!fixed) return models::IntegrateOptions{.stiff = stiff, .max_step = longest};
  const double step = positive_quantity("--step", arguments.step, models::time_unit(info));
  warn_of_gusts(gust, step);
  if (arguments.integrator == "rk4") return models::Rk4Options{.step = step};
  if (arguments.integrator == "rkmk") return models::RkmkOptions{.step = step};
  return models::LieGroupOptions{.step = step, .order = 4};
}

/// Parameters that follow from the body, if one is given.
std::map<std::string, double> values_of_body(const SimulateArguments& arguments,
                                             const models::ModelInfo& info) {
  const BodyWords& words = arguments.body;
  for (const std::string& text : words.sizes) number_or_quantity("--size", text, "m");
  if (words.body.empty()) {
    if (words.sizes.empty() && words.unit.empty() && words.density.empty() && words.fluid.empty() &&
        words.added_mass.empty())
      return {};
    throw ArgumentError(
        "--size, --unit, --density, --fluid and --added-mass are of a body: --body was expected");
  }
  // Without densities it is only what is drawn.
  if (io::is_scene_name(arguments.output) && words.density.empty() && words.fluid.empty() &&
      words.added_mass.empty())
    return {};
  if (info.name != "kirchhoff_body")
    throw ArgumentError(fmt::format("--body is for the model \"kirchhoff_body\", not for \"{}\"", info.name));
  return parameters_of(description_of(words));
}

int animate(const SimulateArguments& arguments, const models::ParametricModel& parametric,
            const models::TrajectoryFamily& family, const ModelInWind& flown, double end) {
  if (arguments.forces) throw ArgumentError("a .glb or .usda holds a motion: no --forces was expected");
  if (arguments.cloud.json) throw ArgumentError("a .glb or .usda holds a motion: no --json was expected");
  Animation animation{
      .states = animated_states(parametric.model().info()),
      .body = animated_body({arguments.body.body, arguments.body.sizes, arguments.body.unit}, parametric, {}),
      .model = parametric.model().info().name,
      .parameters = parametric.fixed(),
      .notes = {{"integrator", arguments.integrator}},
      .from = 0.0,
      .to = end,
      .family = &family};
  if (!arguments.coefficients.empty()) animation.notes.emplace_back("coefficients", arguments.coefficients);
  if (!arguments.wind.empty()) {
    animation.notes.emplace_back("wind", arguments.wind);
    if (flown.has_turbulence) animation.notes.emplace_back("seed", std::to_string(seed_of(arguments.cloud)));
  }
  return write_animation(arguments.output, animation);
}

int run_simulate(const SimulateArguments& arguments) {
  check_cloud_words(arguments);
  if (!arguments.output.empty()) {
    const std::vector<std::string> inputs = {arguments.model, arguments.coefficients, arguments.wind,
                                             arguments.body.body};
    if (arguments.cloud.realisations.empty()) {
      check_text_or_scene_output(arguments.output, inputs, arguments.cloud.json ? ".json" : ".csv");
    } else {
      check_output(arguments.output, inputs);  // clouds name more endings
    }
  }
  const auto still = codebooks::open_model(arguments.model);
  const models::ModelInfo& info = still->info();
  if (arguments.forces && info.force_terms.empty()) {
    throw ArgumentError(fmt::format("--forces: model \"{}\" does not list its force by terms", info.name));
  }
  std::map<std::string, std::string> units;
  for (const auto& parameter : info.parameters) units[parameter.name] = parameter.unit;
  for (const auto& state : info.states) units[state.name + "(0)"] = state.unit;
  std::map<std::string, double> values = parse_assignments(arguments.set, units);
  values.merge(values_of_body(arguments, info));  // what is set by itself stays
  const bool in_one_wind = !arguments.wind.empty() && arguments.cloud.realisations.empty();
  const ModelInWind flown = in_one_wind
                                ? model_in_wind(arguments.wind, seed_of(arguments.cloud), still, values)
                                : ModelInWind{.model = still};
  if (in_one_wind && !flown.has_turbulence && !arguments.cloud.seed.empty()) {
    throw ArgumentError(fmt::format(
        "--seed draws turbulence, and {} holds none: [turbulence] was expected there, or no --seed",
        arguments.wind));
  }
  const auto& model = flown.model;
  ModelWithSeries steered{.book = nullptr, .model = model, .values = std::move(values)};
  if (!arguments.coefficients.empty()) {
    steered = model_with_series(arguments.coefficients, model, steered.values);
    warn_of_missed_tolerance(*steered.book, arguments.coefficients);
  }
  require_parameters(arguments.model, steered.model->info(), steered.values);
  const models::ParametricModel parametric(steered.model, steered.values, {});
  warn_of_parameters(*model, parametric.fixed());
  const double end = end_of(arguments, parametric);
  if (steered.book) steered.check_time(end);
  check_frames(arguments, info);
  const Eigen::VectorXd times = even_times(arguments.frames, 0.0, end);
  if (!arguments.cloud.realisations.empty()) return fly_cloud(arguments, parametric, times);
  const auto family = models::integrator_trajectories(steered.model, steered.values, {},
                                                      integrator_of(arguments, info, flown.shortest_gust));
  if (io::is_scene_name(arguments.output)) return animate(arguments, parametric, *family, flown, end);
  const models::FamilyTrajectory trajectory =
      models::trajectory(*family, {}, {times.begin(), times.end()}, models::output_names(family->info()));

  Table table = output_table(info, family->info().outputs, times, trajectory.values);
  if (arguments.forces) table = beside(table, force_table(parametric, times, trajectory.values));
  const models::TrajectoryOutcome& outcome = trajectory.outcome;
  const Eigen::Index rows =
      models::rows_reached(outcome, {times.data(), static_cast<std::size_t>(times.size())});
  bool all_numbers = true;
  for (Eigen::Index c = 0; c < table.rows.cols(); ++c) {
    const std::string& header = table.header[static_cast<std::size_t>(c)];
    all_numbers &= keep_numbers(header.substr(0, header.rfind('[')), table.rows.col(c).head(rows));
  }
  write_answer(arguments.output, arguments.cloud.json
                                     ? json_line(trajectory_json(arguments.model, table, outcome.message))
                                     : io::format_csv(table.header, table.rows));
  if (outcome) return all_numbers ? kDone : kToleranceMissed;
  warn(rows < times.size()
           ? fmt::format("{}; rows from t = {:.6g} on are empty", outcome.message, times[rows])
           : outcome.message);
  return kToleranceMissed;
}

}  // namespace

void add_simulate(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<SimulateArguments>();
  CLI::App* command = app.add_subcommand("simulate", "one trajectory, as CSV; or many in turbulence");
  command
      ->add_option("MODEL", values->model,
                   "name of a model (samara models), or file with equations (MODEL.toml)")
      ->required();
  command->add_option("--set", values->set, kAssignments)->allow_extra_args(false);
  command->add_option("--body", values->body.body,
                      std::string("of kirchhoff_body: its parameters from ") + kBody);
  add_body_words(*command, values->body, false);
  command->add_option("--until", values->until, "end of the trajectory, s or with a unit")
      ->capture_default_str();
  command->add_option("--frames", values->frames, "rows, equally spaced in time")
      ->capture_default_str()
      ->check(whole_number());
  command
      ->add_option(
          "--integrator", values->integrator,
          "cvodes (the reference), bdf (the same for stiff equations), adaptive (orders 7 and 8), or "
          "with fixed steps: rk4, rkmk (the attitude stays a rotation), lie_group (of one rigid body: "
          "neither energy nor momentum drifts)")
      ->check(CLI::IsMember({"cvodes", "bdf", "adaptive", "rk4", "rkmk", "lie_group"}))
      ->capture_default_str();
  command->add_option("--step", values->step,
                      "of rk4, rkmk, lie_group and realisations, s or with a unit; frames divide it further");
  command->add_flag("--forces", values->forces,
                    "add what every force term does: TERM.Fx, TERM.Fy, .. (force), TERM.T.. (torque) in body "
                    "axes, TERM.power, and the kinetic energy where the model has one");
  command->add_option(
      "--coefficients", values->coefficients,
      "codebook of a series (samara fit --series) that parameters follow in time; what else it "
      "holds, such as the start, counts where --set says nothing");
  command->add_option("--wind", values->wind,
                      "of bodies in space: file of a wind (WIND.toml), with its turbulence drawn by --seed");
  add_cloud_words(*command, values->cloud);
  command->add_flag("--json", values->cloud.json,
                    "print one JSON object: the trajectory, or of realisations means, covariances, landings "
                    "and their errors");
  command->add_option("-o,--output", values->output,
                      "CSV file, of realisations also HDF5 (.h5), or the motion of the body (.glb or .usda), "
                      "of which --body, "
                      "--size and --unit may then say what is drawn; stdout if not given");
  on_call(*command, arguments, values, run_simulate);
}

}  // namespace samara::apps
