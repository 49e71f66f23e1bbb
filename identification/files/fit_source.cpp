#include "samara/identification/files/fit_source.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "samara/base/names.h"
#include "samara/base/units.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/composition/mixed_trajectories.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/problem/fit_config.h"
#include "samara/identification/problem/measurement.h"
#include "samara/identification/report/fit_report.h"
#include "samara/identification/report/read_fit.h"
#include "samara/identification/series/series_config.h"
#include "samara/io/text_file.h"
#include "samara/models/checks/parameter_warnings.h"
#include "samara/models/trajectories/reference_trajectories.h"
#include "samara/models/trajectories/step_trajectories.h"

namespace samara::identification {

namespace {

/// Values that differ by less, relative, are the same but for the digits of a file.
constexpr double kSameValue = 1e-6;

/// What is fitted, for messages.
std::string name_of(const FitRequest& request) {
  if (!request.source.empty()) return request.source;
  return request.model ? request.model->info().name : "the codebook";
}

/// Takes coefficients of another fit over: held, or where this one begins.
/// @param names, box of what the source has, and leaves free; delay and gains of the config are added
void take_over(const FitRequest& request, ConfigNames names, std::map<std::string, models::Interval> box,
               FitSource& source) {
  if (request.coefficients.empty()) return;
  for (const models::FamilyCoordinate& unknown : measurement_coordinates(source.options)) {
    names.coordinates[unknown.name] = unknown.unit;
    box[unknown.name] = {unknown.lower, unknown.upper};
  }
  source.coefficients = read_fit(request.coefficients);
  const FitResult& fitted = *source.coefficients;
  if (fitted.status == Termination::failed || fitted.coefficients.empty()) {
    throw InputError(request.coefficients.string(),
                     fmt::format("it holds no coefficients: {}", fitted.message));
  }
  if (!fitted.is_usable())
    source.warnings.add(WarningKind::source,
                        fmt::format("{}: {}", request.coefficients.string(), fitted.message));
  std::vector<std::string> known;
  for (const auto& [name, unit] : names.coordinates) known.push_back(name);
  for (const Coefficient& c : fitted.coefficients) {
    const auto unit = names.coordinates.find(c.name);
    if (unit == names.coordinates.end()) {
      throw InputError(request.coefficients.string(),
                       fmt::format("\"{}\" has no coordinate \"{}\"{}", name_of(request), c.name,
                                   suggestion(c.name, known)));
    }
    if (!same_dimension(unit->second, c.unit)) {
      throw InputError(request.coefficients.string(),
                       fmt::format("\"{}\" is in {}; {} was expected", c.name, c.unit, unit->second));
    }
    FitOptions& options = source.options;
    if (options.unknowns.fixed.contains(c.name)) {
      throw InputError(
          request.coefficients.string(),
          request.config.empty()
              ? fmt::format("it holds \"{}\" twice; once was expected", c.name)
              : fmt::format("it holds \"{}\", which [fixed] of {} holds, too; one of the two was expected",
                            c.name, request.config.string()));
    }
    if (const auto free = box.find(c.name); !predicts_only(request) && free != box.end()) {
      const auto& [lower, upper] = free->second;
      if (!(c.value >= lower && c.value <= upper)) {
        throw InputError(request.coefficients.string(),
                         fmt::format("\"{}\" is {}; a value in its box, {} to {}, was expected", c.name,
                                     c.value, lower, upper));
      }
      options.starts.initial[c.name] = c.value;
      continue;
    }
    // Of each capture's own, it is an unknown again.
    if (std::ranges::count(options.unknowns.per_capture, c.name) > 0) continue;
    options.unknowns.fixed[c.name] = c.value;
    for (std::vector<std::string>* list : {&options.unknowns.shared, &options.unknowns.log_scale})
      std::erase(*list, c.name);
    options.unknowns.box.erase(c.name);
    options.starts.initial.erase(c.name);
    options.priors.coordinates.erase(c.name);
  }
}

/// The config, from its file or from memory.
struct ConfigText {
  std::string text;
  std::string name;  ///< for messages
};

std::optional<ConfigText> config_of(const FitRequest& request) {
  if (!request.config.empty())
    return ConfigText{io::read_text_file(request.config, {.expected = "a config of a fit"}),
                      request.config.string()};
  if (request.config_text.empty()) return std::nullopt;
  return ConfigText{request.config_text, "the config"};
}

void warn_of_missed_tolerance(const codebooks::Codebook& book, const std::string& name, FitSource& source) {
  if (book.certificate() && book.certificate()->met) return;
  source.warnings.add(WarningKind::source,
                      fmt::format("{} has no certificate that meets its tolerance", name));
}

/// Trajectories that the codebook of the config covers come from it.
void cover_by_codebook(const FitRequest& request, FitSource& source) {
  const std::string& file = source.options.solver.codebook;
  source.cover = std::make_shared<const codebooks::Codebook>(codebooks::load(file));
  warn_of_missed_tolerance(*source.cover, file, source);
  source.family = of_file(request.config, [&] {
    if (source.series)
      throw ArgumentError("codebook: [series] integrates, since coefficients change on the way");
    return codebooks::mixed_trajectories(*source.cover, std::move(source.family));
  });
}

void open_model(const FitRequest& request, FitSource& source) {
  const auto model = request.model ? request.model : codebooks::open_model(request.source);
  if (request.reference) {
    throw ArgumentError(fmt::format(
        "--reference says how to fit a codebook; the model \"{}\" is integrated anyway", model->info().name));
  }
  const std::optional<ConfigText> config = config_of(request);
  if (!config) {
    throw ArgumentError(fmt::format("the fit of the model \"{}\" needs --config with a [box] of what is free",
                                    model->info().name));
  }
  const ConfigNames names = config_names(model->info());
  source.options = parse_fit_config(config->text, config->name, names);
  take_over(request, names, source.options.unknowns.box, source);
  std::map<std::string, double> values = fixed_of_model(source.options);
  for (const auto& [name, interval] : source.options.unknowns.box)
    values.emplace(name, 0.5 * (interval.lower + interval.upper));
  source.warnings.add_all(WarningKind::source, models::parameter_warnings(*model, values));
  source.model = model;
  source.series = parse_series_config(config->text, config->name, names);
  source.family = of_file(request.config, [&] {
    const FitOptions& options = source.options;
    const std::vector<std::string> measurement = measurement_names(options);
    for (const auto& [name, value] : options.unknowns.known) {
      if (options.unknowns.box.contains(name) || contains(measurement, name)) continue;
      throw ArgumentError(fmt::format(
          "[known] \"{}\" has no entry in [box]; an interval that holds its values was expected", name));
    }
    return options.solver.step
               ? step_trajectories(model, fixed_of_model(options), options.unknowns.box, *options.solver.step)
               : reference_trajectories(model, fixed_of_model(options), options.unknowns.box);
  });
  if (!source.options.solver.codebook.empty()) cover_by_codebook(request, source);
}

void open_codebook(const FitRequest& request, FitSource& source) {
  source.book = request.book ? request.book
                             : std::make_shared<const codebooks::Codebook>(codebooks::load(request.source));
  const ConfigNames names = config_names(*source.book);
  if (const std::optional<ConfigText> config = config_of(request)) {
    source.options = parse_fit_config(config->text, config->name, names);
    if (!source.options.solver.codebook.empty()) {
      throw InputError(config->name,
                       fmt::format("codebook: \"{}\" is one itself; the name of its model was expected",
                                   name_of(request)));
    }
    if (source.options.solver.step) {
      throw InputError(
          config->name,
          fmt::format("step: \"{}\" is a codebook, and nothing is integrated in steps; a config without "
                      "it, or the name of its model, \"{}\", was expected",
                      name_of(request), source.book->model().name));
    }
    if (parse_series_config(config->text, config->name, names)) {
      throw InputError(config->name,
                       fmt::format("[series] needs equations whose coefficients may change, and \"{}\" is a "
                                   "codebook; the name of its model, \"{}\", was expected",
                                   name_of(request), source.book->model().name));
    }
  }
  std::map<std::string, models::Interval> box;
  for (const codebooks::Coordinate& c : source.book->coordinates()) {
    const auto narrowed = source.options.unknowns.box.find(c.name);
    box[c.name] =
        narrowed == source.options.unknowns.box.end() ? models::Interval{c.lower, c.upper} : narrowed->second;
  }
  take_over(request, names, box, source);
  warn_of_missed_tolerance(*source.book, name_of(request), source);
  source.family = of_file(request.source, [&] {
    if (request.reference) return codebooks::reference_trajectories(*source.book);
    source.book->time("a fit");  // refuses a codebook without
    return codebooks::codebook_trajectories(*source.book);
  });
}

/// Coefficients belong to the model, and to what was held, where they were found.
void doubt_coefficients(const FitRequest& request, FitSource& source) {
  if (!source.coefficients) return;
  const FitResult& fitted = *source.coefficients;
  const models::FamilyInfo& info = source.family->info();
  const std::string file = request.coefficients.string();
  if (fitted.model != info.model) {
    source.warnings.add(
        WarningKind::source,
        fmt::format("{} holds coefficients of the model \"{}\"; here they are those of \"{}\"", file,
                    fitted.model, info.model));
  }
  doubt_held_values(fitted, info, file, source.warnings);
}

}  // namespace

void doubt_held_values(const FitResult& fitted, const models::FamilyInfo& info, const std::string& file,
                       Warnings& warnings) {
  for (const auto& [name, value] : fitted.fixed) {
    const auto here = info.fixed.find(name);
    if (here == info.fixed.end() || name.ends_with("(0)")) continue;
    if (std::abs(here->second - value) <= kSameValue * std::max(std::abs(here->second), std::abs(value)))
      continue;
    warnings.add(
        WarningKind::source,
        fmt::format("the coefficients of {} were found with \"{}\" held at {:.6g}; here it is {:.6g}", file,
                    name, value, here->second));
  }
}

std::vector<Capture> read_all(const std::vector<std::filesystem::path>& files,
                              const std::filesystem::path& sidecar) {
  std::vector<Capture> captures;
  for (const std::filesystem::path& path : files) {
    for (Capture& capture : read_captures(path, sidecar)) captures.push_back(std::move(capture));
  }
  return captures;
}

bool is_model_source(const std::string& text) {
  std::error_code ignored;
  if (codebooks::is_model_file(text)) return true;
  return !std::filesystem::exists(text, ignored) && text.find_first_of("./") == std::string::npos;
}

bool predicts_only(const FitRequest& request) {
  return !has_captures(request) && !request.coefficients.empty();
}

FitSource open_fit_source(const FitRequest& request) {
  FitSource source;
  if (request.book && request.model)
    throw ArgumentError("a fit of a codebook and of a model: one was expected");
  if (const std::optional<ConfigText> config = config_of(request))
    source.prediction = parse_prediction_config(config->text, config->name);
  if (request.model || (!request.book && is_model_source(request.source))) {
    open_model(request, source);
  } else {
    open_codebook(request, source);
  }
  doubt_coefficients(request, source);
  return source;
}

}  // namespace samara::identification
