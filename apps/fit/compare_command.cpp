#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <glog/logging.h>

#include "inputs/assignments.h"
#include "inputs/capture_inputs.h"
#include "options/option_parts.h"
#include "samara/base/names.h"
#include "samara/identification/files/comparison_files.h"
#include "samara/identification/fit/forecast_comparison_report.h"
#include "samara/io/atomic_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"
#include "terminal/text_layout.h"

namespace samara::apps {

namespace {

namespace id = samara::identification;

struct CompareArguments {
  std::vector<std::string> configs;
  std::vector<std::string> sources;  ///< codebook files or model names: one for all, or one for each config
  std::vector<std::string> captures;
  std::string sidecar;  ///< of every table; empty: those beside them
  std::string by;
  std::optional<int> folds;
  std::string span, ahead;  ///< empty: as the configs say
  int replicates = 1000;
  std::uint64_t seed = 1;
  std::string output;
  bool json = false;
};

std::optional<double> seconds_of(const std::string& option, const std::string& text) {
  if (text.empty()) return {};
  return number_or_quantity(option, text, "s");
}

id::ComparisonRequest request_of(const CompareArguments& arguments) {
  id::ComparisonRequest request{
      .sources = arguments.sources,
      .sidecar = arguments.sidecar,
      .by = arguments.by,
      .folds = arguments.folds,
      .span = seconds_of("--span", arguments.span),
      .ahead = seconds_of("--ahead", arguments.ahead),
      .resampling = {.replicates = arguments.replicates, .seed = arguments.seed},
      .progress = progress_line(),
  };
  request.configs.assign(arguments.configs.begin(), arguments.configs.end());
  request.captures.assign(arguments.captures.begin(), arguments.captures.end());
  request.warning = [](const std::string& sentence) {
    clear_progress();
    warn(sentence);
  };
  return request;
}

/// Why there is no table.
std::string nothing_common(const id::ModelComparison& comparison) {
  std::string text = "no forecast is common to all models";
  std::string lacks;
  for (const id::ComparedModel& model : comparison.models) {
    if (!model.no_forecast.empty()) lacks += fmt::format("; of \"{}\": {}", model.name, model.no_forecast);
  }
  if (lacks.empty()) lacks = ", which make theirs of different captures, quantities or times ahead";
  return text + lacks;
}

int run_compare(const CompareArguments& arguments) {
  // Ceres reports through glog, which would print its own lines.
  FLAGS_minloglevel = google::GLOG_FATAL;
  if (!arguments.output.empty()) {
    std::vector<std::string> inputs = arguments.configs;
    inputs.insert(inputs.end(), arguments.sources.begin(), arguments.sources.end());
    for (std::string& file : files_of_captures(arguments.captures, arguments.sidecar))
      inputs.push_back(std::move(file));
    check_text_output(arguments.output, inputs, ".json");
  }
  const id::ModelComparison comparison = id::compare_files(request_of(arguments));
  clear_progress();
  if (!arguments.output.empty()) io::write_text_atomically(arguments.output, id::comparison_json(comparison));
  print(arguments.json ? id::comparison_json(comparison)
                       : wrapped_prose(printable(id::comparison_text(comparison), "\n")));
  if (!comparison.quantities.empty()) return kDone;
  complain(nothing_common(comparison));
  return kToleranceMissed;
}

}  // namespace

void add_compare(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<CompareArguments>();
  CLI::App* command =
      app.add_subcommand("compare", "which model predicts captures best that its fit has not seen");
  command
      ->add_option("CONFIG", values->configs,
                   "configs of fits, TOML: [prediction] says what is seen of a capture, and how far ahead")
      ->required();
  command
      ->add_option("--model", values->sources,
                   "models or codebooks, as of samara fit: one for all configs, or one for each")
      ->required();
  command
      ->add_option("--left-out", values->captures,
                   "captures, each left out in turn: tables, or sidecars (.toml) that map one")
      ->required();
  command->add_option("--sidecar", values->sidecar,
                      "what the columns of all tables given are, TOML, in place of sidecars beside them");
  command
      ->add_option(
          "--by", values->by,
          "label of captures: all with one text are left out together, in turn; \"id\" for each alone")
      ->required();
  command
      ->add_option("--folds", values->folds,
                   "leave out that many parts of them, not each text alone: fewer fits")
      ->check(whole_number());
  command->add_option(
      "--span", values->span,
      "how much of each capture left out is seen, s or with a unit; default: as the config says");
  command->add_option("--ahead", values->ahead,
                      "how far beyond that to predict, s or with a unit; default: as the config says");
  command
      ->add_option("--replicates", values->replicates, "drawings of clusters, for the errors of differences")
      ->capture_default_str()
      ->check(whole_number());
  command->add_option("--seed", values->seed, "of these drawings")
      ->capture_default_str()
      ->check(whole_number<std::uint64_t>());
  command->add_option("-o,--output", values->output, "also write the comparison as JSON to this file");
  command->add_flag("--json", values->json, "print one JSON object instead of the tables");
  on_call(*command, arguments, values, run_compare);
}

}  // namespace samara::apps
