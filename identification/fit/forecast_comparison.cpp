#include "samara/identification/fit/forecast_comparison.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/streams.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

const char* const kOfModel = "model";

/// One forecast, by every predictor; NaN where one says nothing.
struct Row {
  int cluster = 0;
  std::vector<double> distances;
};

using Part = std::pair<std::string, std::string>;  ///< file and id

/// What is said of one quantity: models in their order, then baselines.
struct Table {
  std::vector<std::string> names;
  std::size_t models = 0;
  std::map<Part, Row> rows;
};

std::vector<std::string> baselines_of(const ForecastsOfModel& model, const std::string& quantity) {
  std::vector<std::string> names;
  for (const ForecastError& e : model.errors) {
    if (e.quantity == quantity && e.predictor != kOfModel && std::ranges::count(names, e.predictor) == 0)
      names.push_back(e.predictor);
  }
  return names;
}

Table table_of(std::span<const ForecastsOfModel> models, const std::string& quantity,
               const ClusterOfCapture& clusters) {
  Table table{.names = {}, .models = models.size(), .rows = {}};
  for (const ForecastsOfModel& model : models) table.names.push_back(model.name);
  const std::vector<std::string> baselines = baselines_of(models.front(), quantity);
  table.names.insert(table.names.end(), baselines.begin(), baselines.end());
  for (std::size_t m = 0; m < models.size(); ++m) {
    for (const ForecastError& e : models[m].errors) {
      if (e.quantity != quantity) continue;
      const auto cluster = clusters.find({e.file, e.motion});
      if (cluster == clusters.end())
        throw ArgumentError(fmt::format("the capture \"{}\" of a forecast is in no cluster", e.motion));
      Row& row = table.rows[{e.file, e.part}];
      row.cluster = cluster->second;
      row.distances.resize(table.names.size(), std::nan(""));
      if (e.predictor == kOfModel) {
        row.distances[m] = e.distance;
      } else if (m == 0) {
        const auto place = std::ranges::find(baselines, e.predictor) - baselines.begin();
        row.distances[models.size() + static_cast<std::size_t>(place)] = e.distance;
      }
    }
  }
  return table;
}

/// Only what all models say, and only baselines that say all of it.
std::vector<Row> common_rows(Table& table) {
  std::vector<Row> rows;
  for (const auto& [part, row] : table.rows) {
    if (std::none_of(row.distances.begin(), row.distances.begin() + static_cast<std::ptrdiff_t>(table.models),
                     [](double d) { return std::isnan(d); }))
      rows.push_back(row);
  }
  for (std::size_t p = table.names.size(); p-- > table.models;) {
    if (std::ranges::none_of(rows, [p](const Row& row) { return std::isnan(row.distances[p]); })) continue;
    const auto place = static_cast<std::ptrdiff_t>(p);
    table.names.erase(table.names.begin() + place);
    for (Row& row : rows) row.distances.erase(row.distances.begin() + place);
  }
  return rows;
}

struct Statistics {
  std::vector<double> median, rms;  ///< by predictor
};

Statistics statistics_of(const std::vector<const Row*>& rows, std::size_t predictors) {
  Statistics statistics;
  std::vector<double> distances(rows.size());
  for (std::size_t p = 0; p < predictors; ++p) {
    double squares = 0.0;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      distances[k] = rows[k]->distances[p];
      squares += distances[k] * distances[k];
    }
    statistics.median.push_back(median(distances));
    statistics.rms.push_back(std::sqrt(squares / static_cast<double>(rows.size())));
  }
  return statistics;
}

/// The same of clusters drawn with replacement, many times.
std::vector<Statistics> resampled(const std::map<int, std::vector<const Row*>>& clusters,
                                  std::size_t predictors, const ResamplingOptions& options) {
  std::vector<const std::vector<const Row*>*> all;
  for (const auto& [cluster, rows] : clusters) all.push_back(&rows);
  std::vector<Statistics> samples;
  for (int replicate = 0; replicate < options.replicates; ++replicate) {
    Stream stream(options.seed, static_cast<std::uint64_t>(replicate));
    std::vector<const Row*> drawn;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const auto& rows = *all[static_cast<std::size_t>(stream.uniform() * static_cast<double>(all.size()))];
      drawn.insert(drawn.end(), rows.begin(), rows.end());
    }
    samples.push_back(statistics_of(drawn, predictors));
  }
  return samples;
}

/// Of one predictor against another.
ForecastDifference difference(const std::vector<double>& values, const std::vector<Statistics>& samples,
                              std::vector<double> Statistics::*statistic, std::size_t one,
                              std::size_t other) {
  ForecastDifference result{.value = values[one] - values[other]};
  if (samples.empty()) return result;
  double sum = 0.0, squares = 0.0;
  for (const Statistics& sample : samples) {
    const double d = (sample.*statistic)[one] - (sample.*statistic)[other] - result.value;
    sum += d;
    squares += d * d;
  }
  const auto count = static_cast<double>(samples.size());
  result.error = std::sqrt(std::max(0.0, squares - sum * sum / count) / (count - 1.0));
  return result;
}

std::optional<std::size_t> best_plain(const std::vector<double>& values, std::size_t models) {
  if (values.size() == models) return {};
  return static_cast<std::size_t>(
      std::min_element(values.begin() + static_cast<std::ptrdiff_t>(models), values.end()) - values.begin());
}

std::optional<ComparedQuantity> compare_quantity(std::span<const ForecastsOfModel> models,
                                                 const ForecastError& like, const ClusterOfCapture& clusters,
                                                 const ResamplingOptions& options) {
  Table table = table_of(models, like.quantity, clusters);
  const std::vector<Row> rows = common_rows(table);
  if (rows.empty()) return {};
  std::map<int, std::vector<const Row*>> by_cluster;
  std::vector<const Row*> all;
  for (const Row& row : rows) {
    by_cluster[row.cluster].push_back(&row);
    all.push_back(&row);
  }
  const std::size_t count = table.names.size();
  const Statistics whole = statistics_of(all, count);
  const std::vector<Statistics> samples =
      by_cluster.size() < 2 ? std::vector<Statistics>{} : resampled(by_cluster, count, options);
  const auto by_median = best_plain(whole.median, table.models), by_rms = best_plain(whole.rms, table.models);
  ComparedQuantity result{.quantity = like.quantity,
                          .unit = like.unit,
                          .forecasts = static_cast<int>(rows.size()),
                          .clusters = static_cast<int>(by_cluster.size()),
                          .best_by_median = by_median ? table.names[*by_median] : "",
                          .best_by_rms = by_rms ? table.names[*by_rms] : ""};
  const auto compared = [&](std::vector<double> Statistics::*statistic, std::size_t p,
                            const std::optional<std::size_t>& plain) {
    const std::vector<double>& values = whole.*statistic;
    ComparedStatistic one{.value = values[p], .to_first = {}, .to_plain = {}};
    if (p != 0) one.to_first = difference(values, samples, statistic, p, 0);
    if (plain && *plain != p) one.to_plain = difference(values, samples, statistic, p, *plain);
    return one;
  };
  for (std::size_t p = 0; p < count; ++p) {
    ComparedPredictor predictor{.name = table.names[p], .is_plain = p >= table.models};
    predictor.median = compared(&Statistics::median, p, by_median);
    predictor.rms = compared(&Statistics::rms, p, by_rms);
    if (p < table.models) {
      predictor.missed = static_cast<int>(std::ranges::count_if(
          table.rows, [p](const auto& entry) { return std::isnan(entry.second.distances[p]); }));
    }
    result.predictors.push_back(std::move(predictor));
  }
  return result;
}

}  // namespace

std::vector<ComparedQuantity> compare_forecasts(std::span<const ForecastsOfModel> models,
                                                const ClusterOfCapture& clusters,
                                                const ResamplingOptions& options) {
  if (models.empty()) throw ArgumentError("there is no model to compare; one or more were expected");
  if (options.replicates < 2) {
    throw ArgumentError(
        fmt::format("replicates is {}; 2 samples of clusters or more were expected", options.replicates));
  }
  std::vector<std::string> seen;
  std::vector<ComparedQuantity> compared;
  for (const ForecastError& e : models.front().errors) {
    if (std::ranges::count(seen, e.quantity) > 0) continue;
    seen.push_back(e.quantity);
    if (auto quantity = compare_quantity(models, e, clusters, options))
      compared.push_back(std::move(*quantity));
  }
  return compared;
}

}  // namespace samara::identification
