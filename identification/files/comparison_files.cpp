#include "samara/identification/files/comparison_files.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "samara/identification/files/fit_source.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segments.h"

namespace samara::identification {

namespace {

/// One config with its source, opened, and the captures that it is about.
struct Contender {
  ComparedModel model;
  std::filesystem::path config;
  FitSource source;
  PredictionOptions prediction;
  std::vector<Capture> captures;
};

void check_request(const ComparisonRequest& request) {
  if (request.configs.empty())
    throw ArgumentError("there is no config to compare; one for each model or variant was expected");
  if (request.captures.empty())
    throw ArgumentError("there is no capture; files whose motions are to be predicted were expected");
  if (request.by.empty())
    throw ArgumentError("the label of the clusters that are left out in turn was expected");
  if (request.sources.size() != 1 && request.sources.size() != request.configs.size()) {
    throw ArgumentError(
        fmt::format("{} models or codebooks for {} configs; one for all, or one for each, was expected",
                    request.sources.size(), request.configs.size()));
  }
  check_resampling(request.resampling);
  for (const auto& [name, time] : {std::pair{"span", request.span}, {"ahead", request.ahead}}) {
    if (time && !(*time > 0.0 && std::isfinite(*time)))
      throw ArgumentError(fmt::format("{} is {} s; more than 0 was expected", name, *time));
  }
}

/// None: each capture is a cluster of its own.
std::vector<std::string> labels_of(const ComparisonRequest& request) {
  if (request.by == "id") return {};
  return {request.by};
}

const std::string& source_of(const ComparisonRequest& request, std::size_t k) {
  return request.sources[request.sources.size() == 1 ? 0 : k];
}

/// The name of the file; with the source, where others have it, too.
std::string name_of(const ComparisonRequest& request, std::size_t k) {
  const std::string name = request.configs[k].stem().string();
  const auto same = std::ranges::count_if(
      request.configs, [&](const std::filesystem::path& other) { return other.stem().string() == name; });
  return same == 1 ? name : fmt::format("{} of {}", name, source_of(request, k));
}

PredictionOptions prediction_of(const ComparisonRequest& request, const FitSource& source) {
  const PredictionConfig& config = source.prediction;
  PredictionOptions prediction{
      .stride = config.stride, .hidden = config.hidden, .mixture = config.mixture, .views = config.views};
  const std::optional<double> ahead = request.ahead ? request.ahead : config.ahead;
  if (!ahead)
    throw ArgumentError(
        "the time beyond the span that is to be predicted, `ahead` in [prediction], was expected");
  prediction.ahead = *ahead;
  for (const std::optional<double>& span : {request.span, config.span, source.options.compared.span}) {
    if (!span) continue;
    prediction.span = *span;
    return prediction;
  }
  throw ArgumentError("what is seen of each capture left out, `span` in [prediction], was expected");
}

/// Those that it fits or leaves out.
std::vector<Capture> captures_of(const std::vector<Capture>& given, const FitSource& source) {
  CaptureSplit chosen = split(given, source.prediction);
  for (Capture& capture : chosen.left_out) chosen.fitted.push_back(std::move(capture));
  return std::move(chosen.fitted);
}

Contender open_contender(const ComparisonRequest& request, std::size_t k, const std::vector<Capture>& given) {
  Contender one{.model = {.name = name_of(request, k), .source = source_of(request, k)},
                .config = request.configs[k],
                .source = open_fit_source({.source = source_of(request, k), .config = request.configs[k]}),
                .prediction = {},
                .captures = {}};
  one.model.model = one.source.family->info().model;
  return of_file(one.config, [&] {
    if (one.source.series)
      throw ArgumentError(
          "a series holds for the captures it was fitted to, and predicts none; a config without [series] "
          "was "
          "expected");
    one.prediction = prediction_of(request, one.source);
    one.captures = captures_of(given, one.source);
    FitOptions& options = one.source.options;
    options.uncertainty.cluster_by = labels_of(request);
    options.progress = request.progress;
    const FitProblem problem = make_problem(one.source.family->info(), one.captures, options);
    one.model.coefficients = static_cast<int>(problem.shared.size());
    return std::move(one);
  });
}

Folds folds_of(const ComparisonRequest& request, const Contender& one) {
  const std::vector<int> clusters = clusters_of(one.captures, labels_of(request));
  return {.count = request.folds.value_or(clusters.empty() ? 0 : 1 + *std::ranges::max_element(clusters))};
}

ClusterOfCapture clusters_by_capture(const std::vector<Capture>& captures, const ComparisonRequest& request) {
  const std::vector<int> clusters = clusters_of(captures, labels_of(request));
  ClusterOfCapture cluster_of;
  for (std::size_t k = 0; k < captures.size(); ++k) {
    const auto [place, is_new] = cluster_of.emplace(std::pair{captures[k].file, captures[k].id}, clusters[k]);
    if (!is_new)
      throw ArgumentError(fmt::format(
          "there are two captures \"{}\"; a name of its own was expected for each", captures[k].id));
  }
  return cluster_of;
}

/// From a fit of all captures.
/// @returns what that fit warns of
Warnings add_evidence(Contender& one) {
  FitOptions options = one.source.options;
  options.uncertainty = options.uncertainty.without_intervals();
  std::shared_ptr<const FitObjective> objective;
  const FitResult fitted = fit(*one.source.family, one.captures, options, objective);
  if (!objective) {
    one.model.no_evidence = fmt::format("the fit of all captures failed: {}", fitted.message);
    return fitted.warnings;
  }
  const Outcome<Evidence> evidence = objective->evidence();
  if (evidence) {
    one.model.evidence = *evidence;
  } else {
    one.model.no_evidence = evidence.ending().message;
  }
  return fitted.warnings;
}

}  // namespace

ModelComparison compare_files(const ComparisonRequest& request) {
  const auto begin = std::chrono::steady_clock::now();
  check_request(request);
  ModelComparison comparison{.by = request.by};
  const auto tell = [&](const std::string& name, const Warnings& warnings) {
    for (const Warning& w : warnings) {
      const std::string sentence = fmt::format("{}: {}", name, w.sentence);
      if (comparison.warnings.add(w.kind, sentence) && request.warning) request.warning(sentence);
    }
  };
  const std::vector<Capture> given = read_all(request.captures, request.sidecar);
  const ClusterOfCapture clusters = clusters_by_capture(given, request);
  std::vector<Contender> contenders;
  for (std::size_t k = 0; k < request.configs.size(); ++k) {
    contenders.push_back(open_contender(request, k, given));
    const Contender& one = contenders.back();
    tell(one.model.name, one.source.warnings);
    of_file(one.config, [&] {
      check_folds(*one.source.family, one.captures, one.source.options, one.prediction,
                  folds_of(request, one));
    });
  }
  std::vector<ForecastsOfModel> forecasts;
  for (Contender& one : contenders) {
    tell(one.model.name, of_file(one.config, [&] { return add_evidence(one); }));
    Warnings warnings;
    const Folds folds = folds_of(request, one);
    ForecastErrors made = of_file(one.config, [&] {
      return cross_validated_errors(*one.source.family, one.captures, one.source.options, one.prediction,
                                    folds, warnings);
    });
    forecasts.push_back({one.model.name, std::move(made.errors)});
    one.model.no_forecast = std::move(made.lack);
    tell(one.model.name, warnings);
    comparison.models.push_back(one.model);
    comparison.folds = std::max(comparison.folds, folds.count);
  }
  comparison.quantities = compare_forecasts(forecasts, clusters, request.resampling);
  for (const ComparedQuantity& q : comparison.quantities)
    comparison.clusters = std::max(comparison.clusters, q.clusters);
  comparison.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return comparison;
}

}  // namespace samara::identification
