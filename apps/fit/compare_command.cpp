#include <optional>
#include <string>

#include <fmt/format.h>
#include <glog/logging.h>

#include "inputs/assignments.h"
#include "options/commands.h"
#include "samara/base/names.h"
#include "samara/identification/files/comparison_files.h"
#include "samara/identification/fit/forecast_comparison_report.h"
#include "samara/io/atomic_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

namespace id = samara::identification;

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

}  // namespace

int run(const CompareArguments& arguments) {
  // Ceres reports through glog, which would print its own lines.
  FLAGS_minloglevel = google::GLOG_FATAL;
  if (!arguments.output.empty()) {
    std::vector<std::string> inputs = arguments.configs;
    inputs.insert(inputs.end(), arguments.captures.begin(), arguments.captures.end());
    inputs.insert(inputs.end(), arguments.sources.begin(), arguments.sources.end());
    inputs.push_back(arguments.sidecar);
    check_output(arguments.output, inputs);
  }
  const id::ModelComparison comparison = id::compare_files(request_of(arguments));
  clear_progress();
  if (!arguments.output.empty()) io::write_text_atomically(arguments.output, id::comparison_json(comparison));
  print(arguments.json ? id::comparison_json(comparison) : printable(id::comparison_text(comparison), "\n"));
  if (!comparison.quantities.empty()) return kDone;
  complain("no forecast is common to all models");
  return kToleranceMissed;
}

}  // namespace samara::apps
