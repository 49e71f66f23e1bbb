#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <glog/logging.h>

#include "inputs/assignments.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/text.h"
#include "samara/codebooks/file/file_format.h"
#include "samara/codebooks/file/save.h"
#include "samara/identification/files/fit_files.h"
#include "samara/identification/report/fit_page.h"
#include "samara/identification/report/fit_report.h"
#include "samara/identification/series/series_codebook.h"
#include "samara/identification/series/series_report.h"
#include "samara/io/atomic_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"
#include "terminal/text_layout.h"

namespace samara::apps {

namespace {

namespace id = samara::identification;

struct FitArguments {
  std::string source;  ///< codebook file or model name
  std::vector<std::string> captures;
  std::string sidecar;  ///< of every table; empty: those beside them
  std::string petab;    ///< folder for the tables of a PEtab problem
  std::string config;
  std::string span;
  std::string coefficients;  ///< JSON of another fit
  bool reference = false;
  bool profiles = false;
  std::vector<std::string> left_out;
  std::string left_out_span;
  std::string ahead;
  std::string output;
  std::string report;
  std::string series;  ///< codebook of a series to write
  bool json = false;
};

/// s; empty where the command does not say.
std::optional<double> time_of(const std::string& option, const std::string& text) {
  if (text.empty()) return {};
  return positive_quantity(option, text, "s");
}

id::FitRequest request_of(const FitArguments& arguments) {
  id::FitRequest request{.source = arguments.source,
                         .sidecar = arguments.sidecar,
                         .config = arguments.config,
                         .coefficients = arguments.coefficients,
                         .span = time_of("--span", arguments.span),
                         .left_out_span = time_of("--left-out-span", arguments.left_out_span),
                         .ahead = time_of("--ahead", arguments.ahead),
                         .reference = arguments.reference,
                         .profiles = arguments.profiles,
                         .needs_series = !arguments.series.empty(),
                         .progress = progress_line()};
  request.captures.assign(arguments.captures.begin(), arguments.captures.end());
  request.left_out.assign(arguments.left_out.begin(), arguments.left_out.end());
  request.warning = [](const std::string& sentence) {
    clear_progress();
    warn(sentence);
  };
  return request;
}

/// Parameters, then simulations.
std::vector<std::string> petab_files(const FitArguments& arguments) {
  const std::filesystem::path folder = arguments.petab;
  return {(folder / "parameters.tsv").string(), (folder / "simulations.tsv").string()};
}

/// Before any work: what would be overwritten, or cannot be written.
void check_outputs(const FitArguments& arguments, const id::FitRequest& request) {
  std::vector<std::string> inputs;
  for (const std::filesystem::path& file : id::files_read(request)) inputs.push_back(file.string());
  std::vector<std::pair<std::string, std::string>> written = {
      {"--report", arguments.report}, {"--output", arguments.output}, {"--series", arguments.series}};
  if (!arguments.petab.empty())
    for (const std::string& file : petab_files(arguments)) written.emplace_back("--petab", file);
  check_outputs_differ(written);
  if (!arguments.output.empty()) check_text_output(arguments.output, inputs, ".json");
  if (!arguments.report.empty()) check_output(arguments.report, inputs);
  if (!arguments.series.empty()) {
    check_file_output(arguments.series, inputs);
    check_replaced_hdf5(arguments.series, "codebook", codebooks::format::kFormat);
  }
  const auto is_problem = [](const std::string& file) {
    const std::string ending = ending_of(file);
    return ending == ".yaml" || ending == ".yml";
  };
  if (!arguments.petab.empty() && std::ranges::none_of(arguments.captures, is_problem))
    throw ArgumentError("--petab writes the tables of a PEtab problem; one (.yaml) was expected as CAPTURE");
  check_ending("--report", arguments.report, ".html");
  if (arguments.petab.empty()) return;
  // Last: a call that is refused leaves no folder behind.
  std::error_code reason;
  std::filesystem::create_directory(arguments.petab, reason);
  if (!std::filesystem::is_directory(arguments.petab, reason))
    throw ArgumentError(
        fmt::format("--petab names \"{}\", which is no folder and cannot become one", arguments.petab));
  for (const std::string& file : petab_files(arguments)) check_output(file, inputs);
}

/// Files before the screen: an answer that cannot be printed is not lost.
void write(const FitArguments& arguments, const id::FitReport& report) {
  const auto json = [&] {
    return report.series ? id::series_json(*report.series) : id::fit_json(report.fit);
  };
  if (!arguments.output.empty()) io::write_text_atomically(arguments.output, json());
  if (!arguments.report.empty()) io::write_text_atomically(arguments.report, id::fit_html(report.fit));
  if (!arguments.petab.empty() && report.fit.status != Termination::failed) {
    io::write_text_atomically(petab_files(arguments)[0], report.petab_parameters);
    io::write_text_atomically(petab_files(arguments)[1], report.petab_simulations);
  }
  if (!arguments.series.empty() && report.series->status != Termination::failed)
    codebooks::save(id::series_codebook(*report.series), arguments.series);
  const auto text = [&] {
    return report.series ? id::series_text(*report.series) : id::fit_text(report.fit);
  };
  print(arguments.json ? json() : wrapped_prose(printable(text(), "\n")));
}

int run_fit(const FitArguments& arguments) {
  // Ceres reports through glog, which would print its own lines; the result carries the same in a sentence.
  FLAGS_minloglevel = google::GLOG_FATAL;
  const id::FitRequest request = request_of(arguments);
  check_outputs(arguments, request);
  const id::FitReport report = id::fit_files(request);
  clear_progress();
  if (is_verbose()) {
    for (const id::CaptureFit& capture : report.fit.captures) {
      for (const std::string& note : capture.notes)
        narrate(fmt::format("capture \"{}\": {}", capture.id, note));
    }
  }
  write(arguments, report);
  if (report.is_usable) return kDone;
  complain(report.message);
  return kToleranceMissed;
}

}  // namespace

void add_fit(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<FitArguments>();
  CLI::App* command = app.add_subcommand("fit", "coefficients with uncertainty from captured trajectories");
  command
      ->add_option(
          "SOURCE", values->source,
          "codebook file, or a model by its name or its file of equations (with a config that has a [box])")
      ->required();
  // Not required for the parser, which would take the last capture left out for one to fit.
  command->add_option("CAPTURE", values->captures,
                      "capture files: tables, or sidecars (.toml) that map one; or one PEtab problem "
                      "(.yaml), config included");
  command->add_option("--sidecar", values->sidecar,
                      "what the columns of all tables given are, TOML, in place of sidecars beside them");
  command->add_option("--config", values->config, "what to fit and how, TOML");
  command->add_option(
      "--coefficients", values->coefficients,
      "JSON of another fit: its coefficients are where this one begins, or held where the "
      "config has no box for them; without a CAPTURE all are held, and --left-out is predicted");
  command->add_option("--span,--window", values->span,
                      "only this much of each capture from its first frame, s or with a unit");
  command->add_flag("--reference", values->reference,
                    "integrate (CVODES with sensitivities) instead of querying the codebook; only with one");
  command->add_flag("--profiles", values->profiles,
                    "fit again with each coefficient held at other values: intervals, and whether there is a "
                    "limit to both sides");
  command->add_option(
      "--left-out", values->left_out,
      "captures to predict, one or more: their span is seen, with the coefficients held, and --ahead is "
      "compared");
  command->add_option("--left-out-span,--left-out-window", values->left_out_span,
                      "how much of each of them is seen, s or with a unit; default: as --span");
  command->add_option("--ahead", values->ahead, "how far beyond the span to predict, s or with a unit");
  command->add_option("--petab", values->petab,
                      "of a PEtab problem: also write its tables as the fit leaves them, parameters.tsv and "
                      "simulations.tsv, into this folder");
  command->add_option("--series", values->series,
                      "write the coefficients that change in time, those of [series] in the config, to this "
                      "codebook, for samara simulate --coefficients");
  command->add_option("-o,--output", values->output, "also write the result as JSON to this file");
  command->add_option("--report", values->report, "also write a page for the browser to this file, HTML");
  command->add_flag("--json", values->json, "print one JSON object instead of the table");
  on_call(*command, arguments, values, run_fit);
}

}  // namespace samara::apps
