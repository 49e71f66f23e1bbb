#include "samara/identification/files/fit_files.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/base/errors.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/captures/capture_suspicions.h"
#include "samara/identification/captures/gravity_check.h"
#include "samara/identification/files/fit_source.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fit_warnings.h"
#include "samara/identification/fit/mass_check.h"
#include "samara/identification/fit/prediction.h"
#include "samara/identification/petab/petab_problem.h"
#include "samara/identification/petab/petab_result.h"
#include "samara/identification/problem/segments.h"
#include "samara/io/toml_document.h"

namespace samara::identification {

namespace {

/// How captures left out are predicted, if there are any.
std::optional<PredictionOptions> prediction_of(const FitRequest& request, const FitSource& source) {
  const PredictionConfig& config = source.prediction;
  if (request.left_out.empty() && config.left_out.empty() && !config.folds) {
    if (!request.ahead && !request.left_out_span) return {};
    throw ArgumentError(
        fmt::format("{} says how to predict captures; --left-out, with their files, was expected",
                    request.ahead ? "--ahead" : "--left-out-span"));
  }
  if (config.folds && !request.left_out.empty()) {
    throw ArgumentError(
        "--left-out names captures to predict, and the config has folds, where every capture is left out "
        "once; one of the two was expected");
  }
  PredictionOptions prediction{
      .stride = config.stride, .hidden = config.hidden, .mixture = config.mixture, .views = config.views};
  const std::optional<double> ahead = request.ahead ? request.ahead : config.ahead;
  if (!ahead) {
    throw ArgumentError(
        "--left-out needs --ahead, or `ahead` in [prediction]: the time beyond the span that is to be "
        "predicted");
  }
  prediction.ahead = *ahead;
  for (const std::optional<double>& span :
       {request.left_out_span, config.span, request.span, source.options.compared.span}) {
    if (!span) continue;
    prediction.span = *span;
    return prediction;
  }
  throw ArgumentError(
      "--left-out needs --left-out-span or --span, or a span in the config: what is seen of each "
      "capture");
}

void check_times(const FitRequest& request) {
  const std::pair<const char*, std::optional<double>> times[] = {
      {"span", request.span}, {"left_out_span", request.left_out_span}, {"ahead", request.ahead}};
  for (const auto& [name, time] : times) {
    if (time && !(*time > 0.0 && std::isfinite(*time)))
      throw ArgumentError(fmt::format("{} is {} s; more than 0 was expected", name, *time));
  }
}

/// Of all captures of a request.
void check_sidecar_of(const FitRequest& request) {
  std::vector<std::filesystem::path> files = request.captures;
  files.insert(files.end(), request.left_out.begin(), request.left_out.end());
  check_sidecar(request.sidecar, files, !request.measured.empty());
}

/// Tells the caller each warning once, as soon as it is known.
class WarningTeller {
 public:
  explicit WarningTeller(const FitRequest& request) : request_(request) {}

  void tell(const Warnings& warnings) {
    for (const Warning& warning : warnings) {
      if (told_.add(warning.kind, warning.sentence) && request_.warning) request_.warning(warning.sentence);
    }
  }

 private:
  const FitRequest& request_;
  Warnings told_;
};

/// The family by integrating the codebook's equations; null for a codebook of a program, or of a model that
/// is not known.
std::unique_ptr<models::TrajectoryFamily> equations_of_codebook(const FitSource& source) {
  if (!source.book || !codebooks::known_model(source.book->model())) return {};
  return codebooks::reference_trajectories(*source.book);
}

std::vector<std::string> check_mass_of(const FitSource& source, const std::vector<Capture>& captures,
                                       const FitResult& fitted) {
  if (source.family->equations() != nullptr)
    return check_mass(*source.family, captures, source.options, fitted);
  const auto family = equations_of_codebook(source);
  if (!family) return {};
  return check_mass(*family, captures, source.options, fitted);
}

/// What is known of the motion of a body that is let go, in the middle of the box.
struct FreeBody {
  std::vector<std::string> upside_down;  ///< an axis of the captures seems to point the other way
  bool falls = true;
};

FreeBody free_body_of(const FitSource& source, const std::vector<Capture>& captures) {
  const auto integrated = source.family->equations() == nullptr ? equations_of_codebook(source) : nullptr;
  const models::TrajectoryFamily& family = integrated ? *integrated : *source.family;
  if (family.equations() == nullptr) return {};
  std::vector<double> middle;
  for (const models::FamilyCoordinate& c : family.info().coordinates)
    middle.push_back(0.5 * (c.lower + c.upper));
  return {check_gravity(*family.equations(), middle, captures), falls(*family.equations(), middle)};
}

/// Coefficients that change in time.
FitReport series_of(const FitRequest& request, const FitSource& source, const std::vector<Capture>& captures,
                    WarningTeller& teller) {
  if (!request.left_out.empty()) {
    throw ArgumentError(
        "--left-out asks for predictions, and a series holds for the captures it was fitted to; a config "
        "without [series] was expected");
  }
  if (request.profiles) {
    throw ArgumentError(
        "--profiles are of coefficients that stay constant; a config without [series] was expected");
  }
  FitReport report;
  report.series = of_file(request.config,
                          [&] { return fit_series(source.model, captures, source.options, *source.series); });
  report.series->warnings.add_all(source.warnings);
  teller.tell(report.series->warnings);
  report.fit = report.series->fit;
  report.fit.warnings.add_all(source.warnings);
  report.is_usable = report.series->status == Termination::converged;
  report.message = report.series->message;
  return report;
}

std::vector<std::string> texts_of(const std::vector<std::filesystem::path>& paths) {
  std::vector<std::string> texts;
  for (const std::filesystem::path& path : paths) texts.push_back(path.string());
  return texts;
}

/// All that is fitted, and all that is left out.
CaptureSplit read_split(const FitRequest& request, const FitSource& source) {
  if (!has_captures(request) && request.left_out.empty())
    throw ArgumentError(
        "there is no CAPTURE; files to fit, or with --coefficients --left-out and files to predict, were "
        "expected");
  if (!has_captures(request) && request.coefficients.empty()) {
    throw ArgumentError(
        fmt::format("there is no CAPTURE to fit: all files given follow --left-out ({}); captures before it, "
                    "or --coefficients, were expected",
                    fmt::join(texts_of(request.left_out), ", ")));
  }
  return of_file(request.config, [&] {
    std::vector<Capture> given = read_all(request.captures, request.sidecar);
    given.insert(given.end(), request.measured.begin(), request.measured.end());
    std::vector<Capture> left_out = read_all(request.left_out, request.sidecar);
    if (given.empty() && !source.prediction.left_out.empty())
      return CaptureSplit{{}, split(left_out, source.prediction).left_out};
    CaptureSplit captures = split(given, source.prediction);
    for (Capture& capture : left_out) captures.left_out.push_back(std::move(capture));
    if (has_captures(request) && captures.fitted.empty())
      throw ArgumentError("no capture is left to fit; sidecar and [prediction] leave out all of them");
    return captures;
  });
}

/// Nothing is fitted but what is each capture's own: of the fit that gave the coefficients nothing is repeated but
/// those, and how captures were seen.
FitResult predicted(const FitRequest& request, const FitSource& source, const std::vector<Capture>& left_out,
                    const PredictionOptions& prediction) {
  FitResult given = *source.coefficients;
  add_predictions(*source.family, left_out, source.options, prediction, given);
  FitResult result{
      .status = Termination::converged,
      .message = fmt::format("nothing was fitted; coefficients from {}", request.coefficients.string())};
  result.warnings = std::move(given.warnings);
  result.setup = std::move(given.setup);
  result.predictions = std::move(given.predictions);
  result.capture_predictions = std::move(given.capture_predictions);
  result.model = source.family->info().model;
  result.source = source.family->info().source;
  result.loss = to_string(source.options.loss.kind);
  result.fixed = source.family->info().fixed;
  for (const Coefficient& c : given.coefficients) result.fixed[c.name] = c.value;
  return result;
}

/// @param objective null if it is not wanted
FitResult fit_and_predict(const FitSource& source, const CaptureSplit& captures,
                          const std::optional<PredictionOptions>& prediction,
                          std::shared_ptr<const FitObjective>* objective) {
  FitResult result = objective ? fit(*source.family, captures.fitted, source.options, *objective)
                               : fit(*source.family, captures.fitted, source.options);
  result.warnings.add_all(WarningKind::model, check_mass_of(source, captures.fitted, result));
  if (!prediction) return result;
  if (source.prediction.folds) {
    cross_validate(*source.family, captures.fitted, source.options, *prediction, *source.prediction.folds,
                   result);
  } else {
    add_predictions(*source.family, captures.left_out, source.options, *prediction, result, captures.fitted);
  }
  return result;
}

/// The span of the request holds in place of the config's.
void take_span(const FitRequest& request, FitSource& source, std::vector<Capture>& captures) {
  if (!request.span) return;
  if (source.options.compared.stride || source.prediction.folds) {
    source.options.compared.span = request.span;
    return;
  }
  for (Capture& capture : captures) capture = first(capture, *request.span);
  source.options.compared.span.reset();
}

/// The PEtab problem among the captures; nothing where there is none.
std::optional<std::filesystem::path> petab_of(const FitRequest& request) {
  const auto found = std::ranges::find_if(request.captures, is_petab_file);
  if (found == request.captures.end()) return {};
  const bool stands_alone =
      request.captures.size() == 1 && request.measured.empty() && request.left_out.empty();
  if (!stands_alone || !request.config.empty() || !request.config_text.empty() || !request.sidecar.empty()) {
    throw ArgumentError(fmt::format(
        "the PEtab problem \"{}\" holds captures and config of the fit; no other, no --config, no --sidecar "
        "and no --left-out were expected",
        found->string()));
  }
  return *found;
}

/// A request with what a PEtab problem says in place of its file.
FitRequest with_petab(FitRequest request, const std::filesystem::path& path, PetabProblem& problem) {
  std::vector<std::string> free;
  if (!request.book && !request.model) {
    if (is_model_source(request.source)) {
      request.model = codebooks::open_model(request.source);
    } else {
      request.book = std::make_shared<const codebooks::Codebook>(codebooks::load(request.source));
    }
  }
  if (request.book) {
    for (const codebooks::Coordinate& c : request.book->parameters()) free.push_back(c.name);
  }
  problem = read_petab(path, request.book ? config_names(*request.book) : config_names(request.model->info()),
                       free);
  request.captures.clear();
  request.measured = problem.captures;
  request.config_text = problem.config;
  return request;
}

}  // namespace

std::vector<std::filesystem::path> files_read(const FitRequest& request) {
  check_sidecar_of(request);
  std::vector<std::filesystem::path> files;
  for (const auto& paths : {request.captures, request.left_out}) {
    for (const std::filesystem::path& path : paths) {
      if (is_petab_file(path)) {
        const auto read = read_petab_file(path).files();
        files.insert(files.end(), read.begin(), read.end());
        continue;
      }
      const auto read = capture_files(path, request.sidecar);
      files.insert(files.end(), read.begin(), read.end());
    }
  }
  for (const std::filesystem::path& path :
       {std::filesystem::path(request.source), request.config, request.coefficients})
    if (!path.empty()) files.push_back(path);
  if (!request.config.empty()) {
    try {
      if (const auto book = io::TomlTable::read(request.config).optional_string("codebook"))
        files.push_back(request.config.parent_path() / *book);
    } catch (const InputError&) {  // what is wrong in it is said when the fit reads it
    }
  }
  return files;
}

FitReport fit_files(const FitRequest& request) {
  if (const auto path = petab_of(request)) {
    PetabProblem problem;
    const FitRequest plain = with_petab(request, *path, problem);
    FitReport report;
    try {
      report = fit_files(plain);
    } catch (const ArgumentError& error) {
      throw InputError(path->string(), error.what());
    }
    for (const std::string& sentence : petab_noise_outside_bounds(problem, report.fit))
      if (report.fit.warnings.add(WarningKind::noise, sentence) && request.warning) request.warning(sentence);
    report.petab_parameters = petab_parameters(problem, report.fit);
    report.petab_simulations = petab_simulations(problem, report.fit);
    return report;
  }
  check_times(request);
  check_sidecar_of(request);
  WarningTeller teller(request);
  // Kept by the objective, which asks its family.
  const auto kept = std::make_shared<FitSource>(open_fit_source(request));
  FitSource& source = *kept;
  teller.tell(source.warnings);
  if (request.profiles && predicts_only(request))
    throw ArgumentError("--profiles are of coefficients that are fitted; captures to fit were expected");
  source.options.uncertainty.profiles = source.options.uncertainty.profiles || request.profiles;
  const std::optional<PredictionOptions> prediction = prediction_of(request, source);
  CaptureSplit captures = read_split(request, source);
  take_span(request, source, captures.fitted);
  // A fit may take long: warnings about the captures come before it.
  const bool fits = !captures.fitted.empty();
  const std::vector<Capture>& looked_at = fits ? captures.fitted : captures.left_out;
  Warnings of_captures;
  const FreeBody free_body = free_body_of(source, looked_at);
  of_captures.add_all(WarningKind::captures, suspicions_of_all(looked_at, free_body.falls));
  of_captures.add_all(WarningKind::captures, free_body.upside_down);
  of_captures.add_all(WarningKind::captures, moved_times(source.family->info(), looked_at));
  const Warnings early_starts = warnings_of_early_starts(source.family->info(), looked_at, source.options);
  of_captures.add_all(early_starts);
  teller.tell(of_captures);
  if (source.series) return series_of(request, source, captures.fitted, teller);
  if (request.needs_series)
    throw ArgumentError(
        "--series writes coefficients that change in time; a model and a config with [series] were expected");
  if (prediction && fits) {
    of_file(request.config, [&] {
      if (source.prediction.folds)
        return check_folds(*source.family, captures.fitted, source.options, *prediction,
                           *source.prediction.folds);
      check_left_out(*source.family, captures.fitted, captures.left_out, source.options, *prediction);
    });
  }
  source.options.progress = request.progress;
  FitReport report;
  std::shared_ptr<const FitObjective> objective;
  report.fit = of_file(request.config, [&] {
    return fits ? fit_and_predict(source, captures, prediction, request.with_objective ? &objective : nullptr)
                : predicted(request, source, captures.left_out, *prediction);
  });
  if (objective) {
    source.options.progress = {};  // which may not outlive the call
    struct Kept {
      std::shared_ptr<FitSource> source;
      std::shared_ptr<const FitObjective> objective;  // goes first
    };
    const auto owner = std::make_shared<Kept>(Kept{kept, objective});
    report.objective = {owner, objective.get()};
  }
  report.fit.warnings.add_all(source.warnings);
  report.fit.warnings.add_all(WarningKind::captures, free_body.upside_down);
  report.fit.warnings.add_all(early_starts);
  teller.tell(report.fit.warnings);
  report.is_usable = fits ? report.fit.is_usable() : !report.fit.predictions.empty();
  report.message =
      report.is_usable || fits ? report.fit.message : "no capture that was left out could be predicted";
  return report;
}

}  // namespace samara::identification
