#include "fit_source.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>

#include <fmt/format.h>

#include "samara/base/names.h"
#include "samara/base/units.h"
#include "samara/codebooks/file/load.h"
#include "samara/identification/problem/fit_config.h"
#include "samara/identification/report/fit_file.h"
#include "samara/identification/report/fit_report.h"
#include "samara/identification/series/series_config.h"
#include "samara/identification/trajectories/codebook_trajectories.h"
#include "samara/identification/trajectories/reference_trajectories.h"
#include "samara/identification/trajectories/step_trajectories.h"
#include "samara/models/laws/registry.h"
#include "terminal.h"

namespace samara::apps {

namespace {

namespace id = samara::identification;

/// A name that is no file, and has no dot or slash that would make it one, is the name of a model.
bool is_model_name(const std::string& text) {
  std::error_code ignored;
  return !std::filesystem::exists(text, ignored) && text.find_first_of("./") == std::string::npos;
}

/// Whether nothing is fitted: coefficients come from another fit, and there are only captures to predict.
bool predicts_only(const FitArguments& arguments) {
  return arguments.captures.empty() && !arguments.coefficients.empty();
}

/// Takes coefficients of another fit over: held, or where this one begins.
/// @param box of what the source leaves free
void take_over(const FitArguments& arguments, const id::ConfigNames& names,
               std::map<std::string, id::Interval> box, FitSource& source) {
  if (arguments.coefficients.empty()) return;
  source.coefficients = id::read_fit(arguments.coefficients);
  const id::FitResult& fitted = *source.coefficients;
  if (fitted.status == id::FitStatus::failed || fitted.coefficients.empty()) {
    throw InputError(arguments.coefficients, fmt::format("it holds no coefficients: {}", fitted.message));
  }
  if (!fitted.is_usable()) warn(fmt::format("{}: {}", arguments.coefficients, fitted.message));
  std::vector<std::string> known;
  for (const auto& [name, unit] : names.coordinates) known.push_back(name);
  for (const id::Coefficient& c : fitted.coefficients) {
    const auto unit = names.coordinates.find(c.name);
    if (unit == names.coordinates.end()) {
      throw InputError(arguments.coefficients,
                       fmt::format("\"{}\" has no coordinate \"{}\"{}", arguments.source, c.name,
                                   suggestion(c.name, known)));
    }
    if (!same_dimension(unit->second, c.unit)) {
      throw InputError(arguments.coefficients,
                       fmt::format("\"{}\" is in {}; {} was expected", c.name, c.unit, unit->second));
    }
    id::FitOptions& options = source.options;
    if (options.fixed.contains(c.name)) {
      throw InputError(
          arguments.coefficients,
          fmt::format("it holds \"{}\", which [fixed] of {} holds, too; one of the two was expected", c.name,
                      arguments.config));
    }
    if (const auto free = box.find(c.name); !predicts_only(arguments) && free != box.end()) {
      const auto& [lower, upper] = free->second;
      if (!(c.value >= lower && c.value <= upper)) {
        throw InputError(arguments.coefficients,
                         fmt::format("\"{}\" is {}; a value in its box, {} to {}, was expected", c.name,
                                     c.value, lower, upper));
      }
      options.initial[c.name] = c.value;
      continue;
    }
    // Of each capture's own, it is an unknown again.
    if (std::ranges::count(options.per_capture, c.name) > 0) continue;
    options.fixed[c.name] = c.value;
    for (std::vector<std::string>* list : {&options.shared, &options.log_scale}) std::erase(*list, c.name);
    options.box.erase(c.name);
    options.initial.erase(c.name);
    options.priors.erase(c.name);
  }
}

void open_model(const FitArguments& arguments, FitSource& source) {
  const auto model = models::find_model(arguments.source);
  if (arguments.reference) {
    throw ArgumentError(fmt::format(
        "--reference says how to fit a codebook; the model \"{}\" is integrated anyway", arguments.source));
  }
  if (arguments.config.empty()) {
    throw ArgumentError(fmt::format("the fit of the model \"{}\" needs --config with a [box] of what is free",
                                    arguments.source));
  }
  const id::ConfigNames names = id::config_names(model->info());
  source.options = id::read_fit_config(arguments.config, names);
  take_over(arguments, names, source.options.box, source);
  std::map<std::string, double> values = source.options.fixed;
  for (const auto& [name, interval] : source.options.box)
    values.emplace(name, 0.5 * (interval.lower + interval.upper));
  warn_of_parameters(*model, values);
  source.model = model;
  source.series = id::read_series_config(arguments.config, names);
  source.family = of_file(arguments.config, [&] {
    const id::FitOptions& options = source.options;
    for (const auto& [name, value] : options.known) {
      if (options.box.contains(name)) continue;
      throw ArgumentError(fmt::format(
          "[known] \"{}\" has no entry in [box]; an interval that holds its values was expected", name));
    }
    return options.step ? id::step_trajectories(model, options.fixed, options.box, *options.step)
                        : id::reference_trajectories(model, options.fixed, options.box);
  });
}

void open_codebook(const FitArguments& arguments, FitSource& source) {
  source.book = codebooks::load(arguments.source);
  const id::ConfigNames names = id::config_names(*source.book);
  if (!arguments.config.empty()) {
    source.options = id::read_fit_config(arguments.config, names);
    if (id::read_series_config(arguments.config, names)) {
      throw InputError(arguments.config,
                       fmt::format("[series] needs equations whose coefficients may change, and \"{}\" is a "
                                   "codebook; the name of its model, \"{}\", was expected",
                                   arguments.source, source.book->model().name));
    }
  }
  std::map<std::string, id::Interval> box;
  for (const codebooks::Coordinate& c : source.book->coordinates()) {
    const auto narrowed = source.options.box.find(c.name);
    box[c.name] = narrowed == source.options.box.end() ? id::Interval{c.lower, c.upper} : narrowed->second;
  }
  take_over(arguments, names, box, source);
  if (!source.book->certificate() || !source.book->certificate()->met) {
    warn(fmt::format("{} has no certificate that meets its tolerance", arguments.source));
  }
  source.family = of_file(arguments.source, [&] {
    return arguments.reference ? id::reference_trajectories(*source.book)
                               : id::codebook_trajectories(*source.book);
  });
}

}  // namespace

FitSource open_fit_source(const FitArguments& arguments) {
  FitSource source;
  if (!arguments.config.empty()) source.prediction = id::read_prediction_config(arguments.config);
  if (is_model_name(arguments.source)) {
    open_model(arguments, source);
  } else {
    open_codebook(arguments, source);
  }
  return source;
}

}  // namespace samara::apps
