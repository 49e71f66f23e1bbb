#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <glog/logging.h>

#include "assignments.h"
#include "commands.h"
#include "output.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/codebooks/store.h"
#include "samara/identification/capture_file.h"
#include "samara/identification/capture_suspicions.h"
#include "samara/identification/codebook_trajectories.h"
#include "samara/identification/coefficient_series.h"
#include "samara/identification/fit.h"
#include "samara/identification/fit_config.h"
#include "samara/identification/fit_page.h"
#include "samara/identification/fit_report.h"
#include "samara/identification/mass_check.h"
#include "samara/identification/prediction.h"
#include "samara/identification/reference_trajectories.h"
#include "samara/identification/series_config.h"
#include "samara/identification/step_trajectories.h"
#include "samara/io/atomic_file.h"
#include "terminal.h"

namespace samara::apps {

namespace {

namespace id = samara::identification;

/// What is fitted: the trajectories of a codebook (kept alive here) or of a model.
struct Source {
  std::shared_ptr<const models::Model> model;  ///< null for a codebook
  std::optional<id::SeriesOptions> series;     ///< only with a model
  std::optional<codebooks::Codebook> book;
  std::unique_ptr<id::TrajectoryFamily> family;
  id::FitOptions options;
};

/// A name that is no file, and has no dot or slash that would make it one, is the name of a model.
bool is_model_name(const std::string& text) {
  std::error_code ignored;
  return !std::filesystem::exists(text, ignored) && text.find_first_of("./") == std::string::npos;
}

/// What is wrong with values that came from a file is wrong with the file.
template <class Call>
auto of_file(const std::string& file, const Call& call) {
  try {
    return call();
  } catch (const ArgumentError& error) {
    if (file.empty()) throw;
    throw InputError(file, error.what());
  }
}

Source open_source(const FitArguments& arguments) {
  Source source;
  if (is_model_name(arguments.source)) {
    const auto model = models::find_model(arguments.source);
    if (arguments.reference) {
      throw ArgumentError(fmt::format(
          "--reference says how to fit a codebook; the model \"{}\" is integrated anyway", arguments.source));
    }
    if (arguments.config.empty()) {
      throw ArgumentError(fmt::format(
          "the fit of the model \"{}\" needs --config with a [box] of what is free", arguments.source));
    }
    source.options = id::read_fit_config(arguments.config, id::config_names(model->info()));
    std::map<std::string, double> values = source.options.fixed;
    for (const auto& [name, interval] : source.options.box)
      values.emplace(name, 0.5 * (interval.lower + interval.upper));
    warn_of_parameters(*model, values);
    source.model = model;
    source.series = id::read_series_config(arguments.config, id::config_names(model->info()));
    source.family = of_file(arguments.config, [&] {
      const id::FitOptions& options = source.options;
      for (const auto& [name, label] : options.known) {
        if (options.box.contains(name)) continue;
        throw ArgumentError(fmt::format(
            "[known] \"{}\" has no entry in [box]; an interval that holds its values was expected", name));
      }
      return options.step ? id::step_trajectories(model, options.fixed, options.box, *options.step)
                          : id::reference_trajectories(model, options.fixed, options.box);
    });
    return source;
  }
  source.book = codebooks::load(arguments.source);
  if (!arguments.config.empty()) {
    source.options = id::read_fit_config(arguments.config, id::config_names(*source.book));
    if (id::read_series_config(arguments.config, id::config_names(*source.book))) {
      throw InputError(arguments.config,
                       fmt::format("[series] needs equations whose coefficients may change, and \"{}\" is a "
                                   "codebook; the name of its model, \"{}\", was expected",
                                   arguments.source, source.book->model().name));
    }
  }
  if (!source.book->certificate() || !source.book->certificate()->met) {
    warn(fmt::format("{} has no certificate that meets its tolerance", arguments.source));
  }
  source.family = of_file(arguments.source, [&] {
    return arguments.reference ? id::reference_trajectories(*source.book)
                               : id::codebook_trajectories(*source.book);
  });
  return source;
}

std::vector<id::Capture> read_all(const std::vector<std::string>& files) {
  std::vector<id::Capture> captures;
  for (const std::string& path : files) {
    for (id::Capture& capture : id::read_captures(path)) captures.push_back(std::move(capture));
  }
  return captures;
}

/// s
double positive_time(const std::string& option, const std::string& text) {
  const double time = number_or_quantity(option, text, "s");
  if (time > 0.0) return time;
  throw ArgumentError(fmt::format("{} is {} s; more than 0 was expected", option, time));
}

/// How captures left out are predicted, if there are any.
std::optional<id::PredictionOptions> read_prediction(const FitArguments& arguments,
                                                     const id::FitOptions& options) {
  if (arguments.left_out.empty()) {
    if (arguments.ahead.empty()) return {};
    throw ArgumentError(
        "--ahead says how far to predict captures; --left-out, with their files, was expected");
  }
  if (arguments.ahead.empty())
    throw ArgumentError("--left-out needs --ahead, the time beyond the window that is to be predicted");
  id::PredictionOptions prediction;
  prediction.ahead = positive_time("--ahead", arguments.ahead);
  if (!arguments.window.empty()) {
    prediction.window = positive_time("--window", arguments.window);
  } else if (options.window) {
    prediction.window = *options.window;
  } else {
    throw ArgumentError("--left-out needs --window, or a window in the config: what is seen of each capture");
  }
  return prediction;
}

/// Of captures, with all that a sidecar names.
std::vector<std::string> files_read(const FitArguments& arguments) {
  std::vector<std::string> files;
  for (const auto& paths : {arguments.captures, arguments.left_out}) {
    for (const std::string& path : paths) {
      for (const std::filesystem::path& file : id::capture_files(path)) files.push_back(file.string());
    }
  }
  return files;
}

/// Before any work: what would be overwritten, or cannot be written.
void check_outputs(const FitArguments& arguments) {
  std::vector<std::string> inputs = files_read(arguments);
  inputs.push_back(arguments.source);
  inputs.push_back(arguments.config);
  if (!arguments.output.empty()) check_output(arguments.output, inputs);
  if (!arguments.report.empty()) check_output(arguments.report, inputs);
  if (!arguments.series.empty()) check_output(arguments.series, inputs);
  const std::vector<std::pair<std::string, std::string>> written = {
      {"--report", arguments.report}, {"--output", arguments.output}, {"--series", arguments.series}};
  for (std::size_t a = 0; a < written.size(); ++a) {
    for (std::size_t b = a + 1; b < written.size(); ++b) {
      if (written[a].second.empty() || written[b].second.empty()) continue;
      if (std::filesystem::absolute(written[a].second).lexically_normal() !=
          std::filesystem::absolute(written[b].second).lexically_normal()) {
        continue;
      }
      throw ArgumentError(fmt::format("{} and {} both name \"{}\"; two files were expected", written[a].first,
                                      written[b].first, written[a].second));
    }
  }
}

/// Every sentence once.
class Warnings {
 public:
  void say(const std::vector<std::string>& sentences) {
    for (const std::string& sentence : sentences) {
      if (said_.insert(sentence).second) warn(sentence);
    }
  }

 private:
  std::set<std::string> said_;
};

std::vector<std::string> doubts_of_mass(const Source& source, const std::vector<id::Capture>& captures,
                                        const id::FitResult& fitted) {
  if (source.family->equations() != nullptr) {
    return id::mass_doubts(*source.family, captures, source.options, fitted);
  }
  // A program that was sampled, or a model of the user's own, has no equations here.
  const std::vector<std::string> known = models::model_names();
  if (!source.book || std::ranges::count(known, source.book->model().name) == 0) return {};
  return id::mass_doubts(*id::reference_trajectories(*source.book), captures, source.options, fitted);
}

/// Coefficients that change in time.
int run_series(const FitArguments& arguments, const Source& source, const std::vector<id::Capture>& captures,
               Warnings& warnings) {
  if (!arguments.left_out.empty()) {
    throw ArgumentError(
        "--left-out asks for predictions, and a series holds for the captures it was fitted to; a config "
        "without [series] was expected");
  }
  if (arguments.profiles) {
    throw ArgumentError(
        "--profiles are of coefficients that stay constant; a config without [series] was expected");
  }
  const id::CoefficientSeries series = of_file(arguments.config, [&] {
    return id::fit_series(source.model, captures, source.options, *source.series);
  });
  if (!arguments.output.empty()) io::write_text_atomically(arguments.output, id::series_json(series));
  if (!arguments.report.empty()) io::write_text_atomically(arguments.report, id::fit_html(series.fit));
  if (!arguments.series.empty() && series.status != id::FitStatus::failed)
    codebooks::save(id::series_codebook(series), arguments.series);
  print(arguments.json ? id::series_json(series) : printable(id::series_text(series), "\n"));
  warnings.say(series.warnings);
  if (series.status == id::FitStatus::converged) return kDone;
  complain(series.message);
  return kToleranceMissed;
}

}  // namespace

int run(const FitArguments& arguments) {
  // Ceres reports through glog, which would print its own lines; the result carries the same in a sentence.
  FLAGS_minloglevel = google::GLOG_FATAL;
  check_outputs(arguments);
  Source source = open_source(arguments);
  source.options.profiles = source.options.profiles || arguments.profiles;
  const std::optional<id::PredictionOptions> prediction = read_prediction(arguments, source.options);
  std::vector<id::Capture> captures = read_all(arguments.captures);
  if (!arguments.window.empty()) {
    const double window = positive_time("--window", arguments.window);
    for (id::Capture& capture : captures) capture = id::first(capture, window);
    source.options.window.reset();
  }
  // A fit may take long: what is strange about the captures should not have to wait for it.
  Warnings warnings;
  for (const id::Capture& capture : captures) warnings.say(id::remarks(capture));
  if (source.series) return run_series(arguments, source, captures, warnings);
  if (!arguments.series.empty()) {
    throw ArgumentError(
        "--series writes coefficients that change in time; a model and a config with [series] were expected");
  }
  const std::vector<id::Capture> left_out = read_all(arguments.left_out);
  if (prediction) {
    of_file(arguments.config,
            [&] { id::check_left_out(*source.family, captures, left_out, source.options, *prediction); });
  }
  source.options.progress = progress_line();
  const id::FitResult result = of_file(arguments.config, [&] {
    id::FitResult fitted = id::fit(*source.family, captures, source.options);
    for (const std::string& doubt : doubts_of_mass(source, captures, fitted))
      fitted.warnings.push_back(doubt);
    if (prediction) id::add_predictions(*source.family, left_out, source.options, *prediction, fitted);
    return fitted;
  });
  clear_progress();
  if (!arguments.output.empty()) io::write_text_atomically(arguments.output, id::fit_json(result));
  if (!arguments.report.empty()) io::write_text_atomically(arguments.report, id::fit_html(result));
  print(arguments.json ? id::fit_json(result) : printable(id::fit_text(result), "\n"));
  warnings.say(result.warnings);
  if (result.is_usable()) return kDone;
  complain(result.message);
  return kToleranceMissed;
}

}  // namespace samara::apps
