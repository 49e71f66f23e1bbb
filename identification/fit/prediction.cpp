#include "samara/identification/fit/prediction.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/left_out_captures.h"
#include "samara/identification/fit/motion_forecasts.h"
#include "samara/identification/fit/prediction_scores.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segments.h"
#include "samara/pgd/tensors/random.h"

namespace samara::identification {

namespace {

/// The fold of each cluster: as cards are dealt.
std::vector<int> deal(int clusters, const Folds& folds) {
  std::vector<int> order(static_cast<std::size_t>(clusters));
  std::iota(order.begin(), order.end(), 0);
  if (folds.seed) {
    pgd::Random random(*folds.seed);
    for (int k = clusters - 1; k > 0; --k)
      std::swap(order[static_cast<std::size_t>(k)], order[static_cast<std::size_t>(random.below(k + 1))]);
  }
  std::vector<int> fold_of(order.size());
  for (std::size_t k = 0; k < order.size(); ++k)
    fold_of[static_cast<std::size_t>(order[k])] = static_cast<int>(k) % folds.count;
  return fold_of;
}

int count_of(const std::vector<int>& clusters) {
  return clusters.empty() ? 0 : 1 + *std::ranges::max_element(clusters);
}

void add_scores(PredictedCaptures outcome, const PredictionOptions& prediction, FitResult& fitted) {
  add_sentences(outcome, fitted.warnings);
  Scores scores = scores_of(outcome.compared, std::move(outcome.predictions), prediction);
  fitted.predictions = std::move(scores.all);
  fitted.capture_predictions = std::move(scores.by_capture);
}

void check_training(int clusters) {
  if (clusters >= 2) return;
  throw ArgumentError(fmt::format(
      "mixture: shares and errors come from captures of the fit that predict each other, and there {} {} "
      "cluster{} of them; two or more were expected",
      clusters == 1 ? "is" : "are", clusters, clusters == 1 ? "" : "s"));
}

void train(const models::TrajectoryFamily& family, std::span<const Capture> training,
           const FitOptions& options, const PredictionOptions& prediction, PredictedCaptures& outcome);

/// Each fold by a fit of the others, which train a mixture where one is asked for.
/// @param warnings null: not said
/// @param wants_along as look_ahead()
PredictedCaptures predict_by_folds(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                                   const FitOptions& options, const PredictionOptions& prediction,
                                   const Folds& folds, Warnings* warnings, bool wants_along = false) {
  const std::vector<int> clusters = clusters_of(captures, options.uncertainty.cluster_by);
  const std::vector<int> fold_of = deal(count_of(clusters), folds);
  FitOptions plain = options;
  plain.uncertainty = plain.uncertainty.without_intervals();
  PredictedCaptures outcome;
  for (int fold = 0; fold < folds.count; ++fold) {
    std::vector<Capture> others, left_out;
    for (std::size_t k = 0; k < captures.size(); ++k)
      (fold_of[static_cast<std::size_t>(clusters[k])] == fold ? left_out : others).push_back(captures[k]);
    const FitResult of_others = fit(family, others, plain);
    const std::string which = fmt::format("fold {} of {}", fold + 1, folds.count);
    if (warnings && of_others.status != Termination::converged)
      warnings->add(WarningKind::predictions,
                    fmt::format("the fit without {}: {}", which, of_others.message));
    PredictedCaptures of_fold = look_ahead(family, of_others, left_out, options, prediction, wants_along);
    if (prediction.mixture) train(family, others, options, prediction, of_fold);
    outcome.add(std::move(of_fold));
  }
  return outcome;
}

/// Gives predictions the errors that the captures of their fit show, each part of them by a fit of the others.
void train(const models::TrajectoryFamily& family, std::span<const Capture> training,
           const FitOptions& options, const PredictionOptions& prediction, PredictedCaptures& outcome) {
  const int clusters = count_of(clusters_of(training, options.uncertainty.cluster_by));
  check_training(clusters);
  constexpr int kParts = 3;
  PredictionOptions plain = prediction;
  plain.mixture = false;
  PredictedCaptures shown = predict_by_folds(family, training, options, plain,
                                             {.count = std::min(kParts, clusters)}, nullptr, true);
  for (CapturePrediction& one : shown.along) shown.predictions.push_back(std::move(one));
  const auto trained =
      std::make_shared<const MotionForecasts>(outcome.compared, shown.predictions, prediction);
  for (CapturePrediction& one : outcome.predictions) one.trained = trained;
  if (!outcome.predictions.empty())
    outcome.add_sentences(trained->lacks(reach_of(outcome.predictions, prediction)));
  for (std::size_t q = 0; q < outcome.compared.size(); ++q) {
    if (std::string shares = trained->shares(q); !shares.empty()) outcome.shares.push_back(std::move(shares));
  }
}

}  // namespace

void check_left_out(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                    std::span<const Capture> left_out, const FitOptions& options,
                    const PredictionOptions& prediction) {
  check_prediction(family.info(), options, prediction);
  const FitProblem problem = make_problem(family.info(), captures, options);
  refuse_repeated(left_out, "left out");
  if (prediction.mixture && !left_out.empty())
    check_training(count_of(clusters_of(captures, options.uncertainty.cluster_by)));
  for (const Capture& capture : left_out) check_capture(capture, problem);
  for (const std::span<const Capture> all : {captures, left_out})
    check_views(family, all, options, prediction);
  for (const Capture& capture : captures)
    refuse_fitted(capture.whole(), capture.file, capture.checksum, left_out);
}

std::vector<PredictionScore> predict_left_out(const models::TrajectoryFamily& family, const FitResult& fitted,
                                              std::span<const Capture> left_out, const FitOptions& options,
                                              const PredictionOptions& prediction) {
  PredictedCaptures outcome = look_ahead(family, fitted, left_out, options, prediction);
  return scores_of(outcome.compared, std::move(outcome.predictions), prediction).all;
}

void add_predictions(const models::TrajectoryFamily& family, std::span<const Capture> left_out,
                     const FitOptions& options, const PredictionOptions& prediction, FitResult& fitted,
                     std::span<const Capture> training) {
  PredictedCaptures outcome = look_ahead(family, fitted, left_out, options, prediction);
  if (prediction.mixture && !left_out.empty()) train(family, training, options, prediction, outcome);
  add_scores(std::move(outcome), prediction, fitted);
}

void check_folds(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                 const FitOptions& options, const PredictionOptions& prediction, const Folds& folds) {
  check_prediction(family.info(), options, prediction);
  check_views(family, captures, options, prediction);
  const int clusters = count_of(clusters_of(captures, options.uncertainty.cluster_by));
  if (folds.count >= 2 && folds.count <= clusters) {
    if (prediction.mixture) check_training(clusters - (clusters + folds.count - 1) / folds.count);
    return;
  }
  if (clusters < 2) {
    throw ArgumentError(
        fmt::format("folds is {}, and the captures are {} cluster; two clusters or more were expected",
                    folds.count, clusters));
  }
  throw ArgumentError(fmt::format("folds is {}; 2 to {}, the number of clusters of captures, was expected",
                                  folds.count, clusters));
}

void cross_validate(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                    const FitOptions& options, const PredictionOptions& prediction, const Folds& folds,
                    FitResult& fitted) {
  check_folds(family, captures, options, prediction, folds);
  PredictedCaptures outcome =
      predict_by_folds(family, captures, options, prediction, folds, &fitted.warnings);
  add_scores(std::move(outcome), prediction, fitted);
}

namespace {

/// Why no forecast of the model reaches the end of what is to be predicted; empty: some do.
std::string lack_of(const PredictedCaptures& outcome, const std::string& source,
                    const PredictionOptions& prediction) {
  const std::vector<CapturePrediction>& predictions = outcome.predictions;
  const auto reaches = [&](const CapturePrediction& one) { return reaches_end(one, prediction); };
  const auto is_forecast = [&](const CapturePrediction& one) { return reaches(one) && one.failure.empty(); };
  if (std::ranges::any_of(predictions, is_forecast)) return {};
  if (predictions.empty()) {
    return outcome.lacks.empty() ? "its fits failed"
                                 : fmt::format("no capture was predicted: {}", outcome.lacks.front().first);
  }
  if (const std::string sentence = shortfall(predictions, source, prediction); !sentence.empty())
    return fmt::format("{}; an `ahead` of at most {:.4g} s was expected", sentence,
                       reach_of(predictions, prediction));
  return fmt::format("it failed on every capture that reaches {:.4g} s ahead: {}", prediction.ahead,
                     std::ranges::find_if(predictions, reaches)->failure);
}

}  // namespace

ForecastErrors cross_validated_errors(const models::TrajectoryFamily& family,
                                      std::span<const Capture> captures, const FitOptions& options,
                                      const PredictionOptions& prediction, const Folds& folds,
                                      Warnings& warnings) {
  check_folds(family, captures, options, prediction, folds);
  PredictedCaptures outcome = predict_by_folds(family, captures, options, prediction, folds, &warnings);
  ForecastErrors found = {.errors = {}, .lack = lack_of(outcome, family.info().source, prediction)};
  add_sentences(outcome, warnings);
  found.errors = forecast_errors(outcome.compared, std::move(outcome.predictions), prediction);
  return found;
}

}  // namespace samara::identification
