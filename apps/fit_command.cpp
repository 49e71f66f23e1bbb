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
#include "fit_source.h"
#include "output.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/codebooks/file/save.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/captures/capture_suspicions.h"
#include "samara/identification/captures/gravity_check.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/mass_check.h"
#include "samara/identification/fit/prediction.h"
#include "samara/identification/report/fit_page.h"
#include "samara/identification/report/fit_report.h"
#include "samara/identification/series/series_book.h"
#include "samara/identification/series/series_report.h"
#include "samara/identification/trajectories/reference_trajectories.h"
#include "samara/io/atomic_file.h"
#include "samara/models/laws/registry.h"
#include "terminal.h"

namespace samara::apps {

namespace {

namespace id = samara::identification;

bool is_table(const std::string& path) {
  return !path.ends_with(".toml");
}

/// @param sidecar of every table; empty: those beside them
std::vector<id::Capture> read_all(const std::vector<std::string>& files, const std::string& sidecar) {
  std::vector<id::Capture> captures;
  for (const std::string& path : files) {
    auto read =
        !sidecar.empty() && is_table(path) ? id::read_captures(path, sidecar) : id::read_captures(path);
    for (id::Capture& capture : read) captures.push_back(std::move(capture));
  }
  return captures;
}

/// s
double positive_time(const std::string& option, const std::string& text) {
  const double time = number_or_quantity(option, text, "s");
  if (time > 0.0) return time;
  throw ArgumentError(fmt::format("{} is {} s; more than 0 was expected", option, time));
}

/// What the command says, else the config; empty where neither does.
std::optional<double> time_of(const std::string& option, const std::string& text,
                              std::optional<double> in_config) {
  return text.empty() ? in_config : positive_time(option, text);
}

/// How captures left out are predicted, if there are any.
std::optional<id::PredictionOptions> read_prediction(const FitArguments& arguments, const FitSource& source) {
  const id::PredictionConfig& config = source.prediction;
  if (arguments.left_out.empty() && config.left_out.empty() && !config.folds) {
    if (arguments.ahead.empty() && arguments.left_out_window.empty()) return {};
    throw ArgumentError(
        fmt::format("{} says how to predict captures; --left-out, with their files, was expected",
                    arguments.ahead.empty() ? "--left-out-window" : "--ahead"));
  }
  if (config.folds && !arguments.left_out.empty()) {
    throw ArgumentError(
        "--left-out names captures to predict, and the config has folds, where every capture is left out "
        "once; "
        "one of the two was expected");
  }
  id::PredictionOptions prediction{.stride = config.stride, .hidden = config.hidden};
  const auto ahead = time_of("--ahead", arguments.ahead, config.ahead);
  if (!ahead) {
    throw ArgumentError(
        "--left-out needs --ahead, or `ahead` in [prediction]: the time beyond the window that is to be "
        "predicted");
  }
  prediction.ahead = *ahead;
  std::optional<double> window = time_of("--left-out-window", arguments.left_out_window, config.window);
  if (!window) window = time_of("--window", arguments.window, source.options.window);
  if (!window) {
    throw ArgumentError(
        "--left-out needs --left-out-window or --window, or a window in the config: what is seen of each "
        "capture");
  }
  prediction.window = *window;
  return prediction;
}

/// Of captures, with all that a sidecar names.
std::vector<std::string> files_read(const FitArguments& arguments) {
  std::vector<std::string> files;
  for (const auto& paths : {arguments.captures, arguments.left_out}) {
    for (const std::string& path : paths) {
      const bool has_sidecar = !arguments.sidecar.empty() && is_table(path);
      for (const std::filesystem::path& file :
           has_sidecar ? id::capture_files(path, arguments.sidecar) : id::capture_files(path))
        files.push_back(file.string());
    }
  }
  return files;
}

/// Before any work: what would be overwritten, or cannot be written.
void check_outputs(const FitArguments& arguments) {
  std::vector<std::string> inputs = files_read(arguments);
  inputs.push_back(arguments.source);
  inputs.push_back(arguments.config);
  inputs.push_back(arguments.coefficients);
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

/// The family as equations have it; a program that was sampled, or a model of the user's own, has none here.
std::unique_ptr<id::TrajectoryFamily> behind_codebook(const FitSource& source) {
  const std::vector<std::string> known = models::model_names();
  if (!source.book || std::ranges::count(known, source.book->model().name) == 0) return {};
  return id::reference_trajectories(*source.book);
}

std::vector<std::string> doubts_of_mass(const FitSource& source, const std::vector<id::Capture>& captures,
                                        const id::FitResult& fitted) {
  if (source.family->equations() != nullptr)
    return id::mass_doubts(*source.family, captures, source.options, fitted);
  const auto family = behind_codebook(source);
  if (!family) return {};
  return id::mass_doubts(*family, captures, source.options, fitted);
}

/// Whether an axis of the captures seems to point the other way.
std::vector<std::string> doubts_of_gravity(const FitSource& source,
                                           const std::vector<id::Capture>& captures) {
  const auto behind = source.family->equations() == nullptr ? behind_codebook(source) : nullptr;
  const id::TrajectoryFamily& family = behind ? *behind : *source.family;
  if (family.equations() == nullptr) return {};
  std::vector<double> middle;
  for (const id::FitCoordinate& c : family.info().coordinates) middle.push_back(0.5 * (c.lower + c.upper));
  return id::gravity_doubts(*family.equations(), middle, captures);
}

/// Coefficients that change in time.
int run_series(const FitArguments& arguments, const FitSource& source,
               const std::vector<id::Capture>& captures, Warnings& warnings) {
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

/// A sidecar that no table needs would do nothing.
void check_sidecar(const FitArguments& arguments) {
  std::vector<std::string> files = arguments.captures;
  files.insert(files.end(), arguments.left_out.begin(), arguments.left_out.end());
  if (!arguments.sidecar.empty() && std::ranges::none_of(files, is_table)) {
    throw ArgumentError(
        fmt::format("--sidecar \"{}\" says what the columns of tables are, and every capture given is a "
                    "sidecar itself; a table "
                    "was expected",
                    arguments.sidecar));
  }
}

/// All that is fitted, and all that is left out.
id::CaptureSplit read_captures(const FitArguments& arguments, const FitSource& source) {
  if (arguments.captures.empty() && arguments.left_out.empty()) {
    throw ArgumentError(
        "there is no CAPTURE; files to fit, or with --coefficients --left-out and files to "
        "predict, were expected");
  }
  if (arguments.captures.empty() && arguments.coefficients.empty()) {
    throw ArgumentError(
        fmt::format("there is no CAPTURE to fit: all files given stand behind --left-out ({}); "
                    "captures before it, or --coefficients, were expected",
                    fmt::join(arguments.left_out, ", ")));
  }
  return of_file(arguments.config, [&] {
    const std::vector<id::Capture> given = read_all(arguments.captures, arguments.sidecar);
    std::vector<id::Capture> left_out = read_all(arguments.left_out, arguments.sidecar);
    if (given.empty() && !source.prediction.left_out.empty())
      return id::CaptureSplit{{}, id::split(left_out, source.prediction).left_out};
    id::CaptureSplit captures = id::split(given, source.prediction);
    for (id::Capture& capture : left_out) captures.left_out.push_back(std::move(capture));
    if (!arguments.captures.empty() && captures.fitted.empty())
      throw ArgumentError("no capture is left to fit; sidecar and [prediction] leave out all of them");
    return captures;
  });
}

/// Nothing is fitted but what is each capture's own.
id::FitResult predicted(const FitArguments& arguments, const FitSource& source,
                        const std::vector<id::Capture>& left_out, const id::PredictionOptions& prediction) {
  id::FitResult result = *source.coefficients;
  id::add_predictions(*source.family, left_out, source.options, prediction, result);
  result.status = id::FitStatus::converged;
  result.message = fmt::format("nothing was fitted; coefficients from {}", arguments.coefficients);
  result.source = source.family->info().source;
  result.loss = id::to_string(source.options.loss.kind);
  result.fixed = source.family->info().fixed;
  for (const id::Coefficient& c : result.coefficients) result.fixed[c.name] = c.value;
  result.coefficients.clear();
  result.captures.clear();
  result.noise.clear();
  return result;
}

id::FitResult fitted(const FitSource& source, const id::CaptureSplit& captures,
                     const std::optional<id::PredictionOptions>& prediction) {
  id::FitResult result = id::fit(*source.family, captures.fitted, source.options);
  for (const std::string& doubt : doubts_of_mass(source, captures.fitted, result))
    result.warnings.push_back(doubt);
  if (!prediction) return result;
  if (source.prediction.folds) {
    id::cross_validate(*source.family, captures.fitted, source.options, *prediction, *source.prediction.folds,
                       result);
  } else {
    id::add_predictions(*source.family, captures.left_out, source.options, *prediction, result);
  }
  return result;
}

/// The window of the command holds in place of the config's.
void take_window(const FitArguments& arguments, FitSource& source, std::vector<id::Capture>& captures) {
  if (arguments.window.empty()) return;
  const double window = positive_time("--window", arguments.window);
  if (source.options.stride || source.prediction.folds) {
    source.options.window = window;
    return;
  }
  for (id::Capture& capture : captures) capture = id::first(capture, window);
  source.options.window.reset();
}

}  // namespace

int run(const FitArguments& arguments) {
  // Ceres reports through glog, which would print its own lines; the result carries the same in a sentence.
  FLAGS_minloglevel = google::GLOG_FATAL;
  check_sidecar(arguments);
  check_outputs(arguments);
  FitSource source = open_fit_source(arguments);
  source.options.profiles = source.options.profiles || arguments.profiles;
  const std::optional<id::PredictionOptions> prediction = read_prediction(arguments, source);
  id::CaptureSplit captures = read_captures(arguments, source);
  take_window(arguments, source, captures.fitted);
  // A fit may take long: what is strange about the captures should not have to wait for it.
  Warnings warnings;
  const bool fits = !captures.fitted.empty();
  const std::vector<id::Capture>& looked_at = fits ? captures.fitted : captures.left_out;
  warnings.say(id::suspicions_of_all(looked_at));
  const std::vector<std::string> upside_down = doubts_of_gravity(source, looked_at);
  warnings.say(upside_down);
  if (source.series) return run_series(arguments, source, captures.fitted, warnings);
  if (!arguments.series.empty()) {
    throw ArgumentError(
        "--series writes coefficients that change in time; a model and a config with [series] were expected");
  }
  if (prediction && fits) {
    of_file(arguments.config, [&] {
      if (source.prediction.folds)
        return id::check_folds(captures.fitted, source.options, *prediction, *source.prediction.folds);
      id::check_left_out(*source.family, captures.fitted, captures.left_out, source.options, *prediction);
    });
  }
  source.options.progress = progress_line();
  id::FitResult result = of_file(arguments.config, [&] {
    return fits ? fitted(source, captures, prediction)
                : predicted(arguments, source, captures.left_out, *prediction);
  });
  result.warnings.insert(result.warnings.end(), upside_down.begin(), upside_down.end());
  clear_progress();
  if (!arguments.output.empty()) io::write_text_atomically(arguments.output, id::fit_json(result));
  if (!arguments.report.empty()) io::write_text_atomically(arguments.report, id::fit_html(result));
  print(arguments.json ? id::fit_json(result) : printable(id::fit_text(result), "\n"));
  warnings.say(result.warnings);
  if (!fits && result.predictions.empty()) return kToleranceMissed;
  if (result.is_usable()) return kDone;
  complain(result.message);
  return kToleranceMissed;
}

}  // namespace samara::apps
