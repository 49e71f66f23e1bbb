#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "samara/identification/fit/prediction.h"
#include "samara/identification/problem/evidence.h"

/// Which model? Forecasts of the same captures by several models, side by side, and beside the baselines.
///
/// Where predictions are made as distributions (PredictionOptions::mixture), each model also stands as "NAME, mixed",
/// the mixture that its fits train, and all by their continuous ranked probability score (forecasts/proper_scores.h).
///
/// Each model's errors come from cross_validated_errors(), so that no capture helps to predict itself. Compared are the
/// forecasts that all models make, pair by pair, by their median and their root mean square. The error of a difference
/// is its standard deviation over bootstrap samples of clusters (B. Efron, Ann. Statist. 7 (1979) 1-26), drawn
/// with all their forecasts: those of one motion are not independent. Fits of different folds share most of their
/// captures, which it does not see: differences of less than two errors are none.
///
/// "The best plain baseline" is that of the least median for medians, of the least rms for rms, and so on.
namespace samara::identification {

/// What one model was off.
struct ForecastsOfModel {
  std::string name = {};
  std::vector<ForecastError> errors = {};  ///< those of the baselines too; the first model's count
};

/// NaN where there is nothing to compare with, and for the error of fewer than two clusters.
struct ForecastDifference {
  double value = std::numeric_limits<double>::quiet_NaN();
  double error = std::numeric_limits<double>::quiet_NaN();

  /// More than two errors off zero.
  bool is_clear() const { return value > 2.0 * error || value < -2.0 * error; }
};

struct ComparedStatistic {
  double value = 0.0;
  ForecastDifference to_first, to_plain;  ///< this less the first model's, less the best plain baseline's
};

struct ComparedPredictor {
  std::string name = {};
  bool is_plain = false;  ///< a plain baseline, or a mixture of these
  ComparedStatistic median = {}, rms = {};
  ComparedStatistic crps = {};  ///< the mean; NaN where predictions are no distributions
  int missed = 0;               ///< forecasts that others make, and it does not: they are left out for all
};

struct ComparedQuantity {
  std::string quantity = {}, unit = {};
  int forecasts = 0, clusters = 0;
  /// Of the plain baselines; empty: none.
  std::string best_by_median = {}, best_by_rms = {}, best_by_crps = {};
  std::vector<ComparedPredictor> predictors = {};  ///< the models in their order, mixtures, baselines
};

/// The cluster of each capture, by its file and id.
using ClusterOfCapture = std::map<std::pair<std::string, std::string>, int>;

/// How differences are resampled.
struct ResamplingOptions {
  int replicates = 1000;
  std::uint64_t seed = 1;
};

/// @throws ArgumentError for fewer than 2 replicates, or more than a million
void check_resampling(const ResamplingOptions& options);

/// A quantity that no forecast is common for is left out.
/// @throws ArgumentError without a model, for a number of replicates that is refused, and for a capture without a
/// cluster
std::vector<ComparedQuantity> compare_forecasts(std::span<const ForecastsOfModel> models,
                                                const ClusterOfCapture& clusters,
                                                const ResamplingOptions& options = {});

/// What was compared, for the report.
struct ComparedModel {
  std::string name = {};
  std::string source = {}, model = {};
  int coefficients = 0;  ///< that its fits shared between captures
  /// Of all captures together, by Laplace's method (fit_objective.h).
  std::optional<Evidence> evidence = {};
  std::string no_evidence = {};  ///< why there is none, in one sentence
  std::string no_forecast = {};  ///< why it made none, in one sentence; empty: it made some
};

/// The logarithm of a model's evidence less that of the first; nothing where one has none, or they are not of the
/// same values: outputs, captures, and how many.
std::optional<double> evidence_to_first(std::span<const ComparedModel> models, std::size_t model);

struct ModelComparison {
  std::vector<ComparedModel> models = {};
  std::string by = {};  ///< label of the clusters
  int folds = 0;        ///< fits of each model
  int clusters = 0;
  std::vector<ComparedQuantity> quantities = {};
  Warnings warnings = {};
  double seconds = 0.0;
};

}  // namespace samara::identification
