#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "inputs/assignments.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/base/text.h"
#include "samara/codebooks/figures/book_figures.h"
#include "samara/codebooks/file/load.h"
#include "samara/identification/report/fit_figures.h"
#include "samara/io/atomic_file.h"
#include "samara/io/delimited_table.h"
#include "samara/io/svg_chart.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

using codebooks::Codebook;
using Panels = std::vector<io::SvgPanel>;

struct PlotArguments {
  std::string input;  ///< codebook, JSON of a fit, or table
  std::string of;     ///< empty: trajectories of a codebook, captures of a fit
  std::vector<std::string> set;
  std::vector<std::string> outputs;
  std::string capture;  ///< id, or id and file, of a fit
  int points = 64;      ///< of errors
  std::uint64_t seed = 1;
  int columns = 2;
  std::string title;
  std::string output;
  bool json = false;
};

/// What is set, and the middle of the box.
Eigen::VectorXd point_of(const Codebook& book, const PlotArguments& arguments) {
  std::map<std::string, std::string> units;
  for (const codebooks::Coordinate& c : book.parameters()) units[c.name] = c.unit;
  const std::map<std::string, double> values = parse_assignments(arguments.set, units);
  Eigen::VectorXd q = codebooks::middle_of_box(book);
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    const auto value = values.find(book.parameters()[static_cast<std::size_t>(k)].name);
    if (value != values.end()) q[k] = value->second;
  }
  return q;
}

/// @throws ArgumentError for an option that a picture does not take
void check_options(const PlotArguments& arguments, const std::string& picture) {
  struct Option {
    const char* name;
    bool is_given;
    std::vector<std::string> pictures;  ///< that take it
  };
  const PlotArguments defaults;
  const std::vector<Option> options = {
      {"--set", !arguments.set.empty(), {"trajectories"}},
      {"--outputs", !arguments.outputs.empty(), {"trajectories", "error", "indices", "table"}},
      {"--points", arguments.points != defaults.points, {"error"}},
      {"--seed", arguments.seed != defaults.seed, {"error"}},
      {"--capture", !arguments.capture.empty(), {"captures"}}};
  for (const Option& option : options) {
    if (!option.is_given || std::ranges::count(option.pictures, picture) > 0) continue;
    throw ArgumentError(
        fmt::format("{} is of {}, and not of {}", option.name, fmt::join(option.pictures, ", "), picture));
  }
}

/// @throws ArgumentError for a picture of the other kind of file
std::string picture_of(const PlotArguments& arguments, const std::vector<std::string>& possible) {
  if (arguments.of.empty()) return possible.front();
  for (const std::string& name : possible)
    if (name == arguments.of) return name;
  throw ArgumentError(fmt::format("--of is {}, which {} does not have: {} was expected", arguments.of,
                                  arguments.input, fmt::join(possible, ", ")));
}

Panels panels_of_book(const PlotArguments& arguments) {
  const Codebook book = codebooks::load(arguments.input);
  warn_of_missed_tolerance(book, arguments.input);
  const std::string of = picture_of(arguments, {"trajectories", "error", "ranks", "indices"});
  check_options(arguments, of);
  if (of == "error")
    return codebooks::error_panels(book, arguments.points, arguments.seed, arguments.outputs);
  if (of == "ranks") return codebooks::rank_panels(book);
  if (of == "indices") return codebooks::index_panels(book, arguments.outputs);
  return codebooks::trajectory_panels(book, point_of(book, arguments), arguments.outputs);
}

Panels panels_of_fit(const PlotArguments& arguments) {
  const std::string of = picture_of(arguments, {"captures", "profiles"});
  check_options(arguments, of);
  if (of == "profiles") return identification::profile_panels(arguments.input);
  return identification::capture_panels(arguments.input, arguments.capture);
}

/// Every column over the first.
Panels panels_of_table(const PlotArguments& arguments) {
  if (!arguments.of.empty())
    throw ArgumentError(
        fmt::format("--of is {}, but a table is shown as it is: no --of was expected", arguments.of));
  check_options(arguments, "table");
  const io::DelimitedTable table = io::DelimitedTable::read(arguments.input);
  const std::vector<std::string>& header = table.header();
  if (header.size() < 2)
    throw InputError(arguments.input, "it has one column, but at least two were expected");
  const Eigen::VectorXd x = table.numbers(header.front());
  std::vector<std::string> columns(header.begin() + 1, header.end());
  // With the unit or without.
  const auto column_of = [&](const std::string& name) {
    for (const std::string& column : columns)
      if (column == name || column.substr(0, column.find('[')) == name) return column;
    return name;  // which the table refuses
  };
  if (!arguments.outputs.empty()) {
    std::vector<std::string> chosen;
    for (const std::string& name : arguments.outputs) chosen.push_back(column_of(name));
    columns = std::move(chosen);
  }
  Panels panels;
  for (const std::string& column : columns) {
    panels.push_back({.title = column.substr(0, column.find('[')),
                      .x_label = header.front(),
                      .y_label = column,
                      .series = {{.name = {}, .x = x, .y = table.numbers(column)}}});
  }
  return panels;
}

Panels panels_of(const PlotArguments& arguments) {
  const std::string ending = ending_of(arguments.input);
  if (ending == ".json") return panels_of_fit(arguments);
  if (ending == ".csv" || ending == ".tsv") return panels_of_table(arguments);
  return panels_of_book(arguments);
}

int run_plot(const PlotArguments& arguments) {
  if (arguments.columns < 1)
    throw ArgumentError(fmt::format("--columns is {}, expected at least 1", arguments.columns));
  check_output(arguments.output, {arguments.input});
  check_ending("--output", arguments.output, ".svg");
  io::write_text_atomically(arguments.output,
                            io::svg_charts(arguments.title, panels_of(arguments), arguments.columns));
  tell_of_file(arguments.output, arguments.json);
  return kDone;
}

}  // namespace

void add_plot(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<PlotArguments>();
  CLI::App* command = app.add_subcommand("plot", "a picture of a codebook, a fit or a table, as SVG");
  command->add_option("INPUT", values->input, "codebook, fit (.json), or table (.csv, .tsv)")->required();
  command
      ->add_option(
          "--of", values->of,
          "of a codebook: trajectories (the default), error, ranks, indices (of Sobol'); of a fit: captures "
          "(the default), profiles")
      ->check(CLI::IsMember({"trajectories", "error", "ranks", "indices", "captures", "profiles"}));
  command
      ->add_option(
          "--set", values->set,
          std::string("of trajectories; the middle of the box where nothing is said: ") + kAssignments)
      ->allow_extra_args(false);
  command->add_option("--outputs", values->outputs, "to show; default: all");
  command->add_option("--capture", values->capture,
                      "id of a capture of the fit, and where several have it the file, as in \"drop, "
                      "second.csv\"; default: the "
                      "first");
  command->add_option("--points", values->points, "of errors")
      ->capture_default_str()
      ->check(whole_number())
      ->check(CLI::Range(1, 100000));
  command->add_option("--seed", values->seed, "of these points, from 0")
      ->capture_default_str()
      ->check(whole_number<std::uint64_t>());
  command->add_option("--columns", values->columns, "of panels")
      ->capture_default_str()
      ->check(whole_number());
  command->add_option("--title", values->title, "above the picture");
  command->add_option("-o,--output", values->output, "picture to write, .svg")->required();
  command->add_flag("--json", values->json, kJsonOfFile);
  on_call(*command, arguments, values, run_plot);
}

}  // namespace samara::apps
