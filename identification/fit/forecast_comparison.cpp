#include "samara/identification/fit/forecast_comparison.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/base/streams.h"
#include "samara/identification/forecasts/trained_forecasts.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

const char* const kOfModel = "model";

/// One forecast, by every predictor; NaN where one says nothing.
struct Row {
  int cluster = 0;
  std::vector<double> distances, crps;
};

using Part = std::pair<std::string, std::string>;  ///< file and id

/// Whose a column is: one of a model, or what all models have alike.
struct Column {
  std::string name;
  std::optional<std::size_t> model = {};
  std::string predictor = {};  ///< as in ForecastError
};

/// What is said of one quantity: models in their order, then their mixtures, then baselines.
struct Table {
  std::vector<Column> columns;
  std::map<Part, Row> rows;

  std::size_t own() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(columns, [](const Column& c) { return c.model.has_value(); }));
  }
};

bool says(const ForecastsOfModel& model, const std::string& quantity, const std::string& predictor) {
  return std::ranges::any_of(model.errors, [&](const ForecastError& e) {
    return e.quantity == quantity && e.predictor == predictor;
  });
}

std::vector<Column> columns_of(std::span<const ForecastsOfModel> models, const std::string& quantity) {
  std::vector<Column> columns;
  for (std::size_t m = 0; m < models.size(); ++m) columns.push_back({models[m].name, m, kOfModel});
  for (std::size_t m = 0; m < models.size(); ++m) {
    if (says(models[m], quantity, kMixture)) columns.push_back({models[m].name + ", mixed", m, kMixture});
  }
  for (const ForecastError& e : models.front().errors) {
    if (e.quantity == quantity && e.predictor != kOfModel && e.predictor != kMixture &&
        std::ranges::count(columns, e.predictor, &Column::predictor) == 0)
      columns.push_back({e.predictor, {}, e.predictor});
  }
  return columns;
}

Table table_of(std::span<const ForecastsOfModel> models, const std::string& quantity,
               const ClusterOfCapture& clusters) {
  Table table{.columns = columns_of(models, quantity), .rows = {}};
  for (std::size_t m = 0; m < models.size(); ++m) {
    for (const ForecastError& e : models[m].errors) {
      if (e.quantity != quantity) continue;
      const auto cluster = clusters.find({e.file, e.motion});
      if (cluster == clusters.end())
        throw ArgumentError(fmt::format("the capture \"{}\" of a forecast is in no cluster", e.motion));
      Row& row = table.rows[{e.file, e.part}];
      row.cluster = cluster->second;
      row.distances.resize(table.columns.size(), std::nan(""));
      row.crps.resize(table.columns.size(), std::nan(""));
      const auto column = std::ranges::find_if(table.columns, [&](const Column& c) {
        return c.predictor == e.predictor && c.model.value_or(0) == m;
      });
      if (column == table.columns.end()) continue;  // a baseline of a later model
      const auto at = static_cast<std::size_t>(column - table.columns.begin());
      row.distances[at] = e.distance;
      row.crps[at] = e.crps;
    }
  }
  return table;
}

/// Only what all models say, and only baselines that say all of it.
std::vector<Row> common_rows(Table& table) {
  std::vector<Row> rows;
  const std::size_t own = table.own();
  for (const auto& [part, row] : table.rows) {
    if (std::none_of(row.distances.begin(), row.distances.begin() + static_cast<std::ptrdiff_t>(own),
                     [](double d) { return std::isnan(d); }))
      rows.push_back(row);
  }
  for (std::size_t p = table.columns.size(); p-- > own;) {
    if (std::ranges::none_of(rows, [p](const Row& row) { return std::isnan(row.distances[p]); })) continue;
    const auto place = static_cast<std::ptrdiff_t>(p);
    table.columns.erase(table.columns.begin() + place);
    for (Row& row : rows) {
      row.distances.erase(row.distances.begin() + place);
      row.crps.erase(row.crps.begin() + place);
    }
  }
  return rows;
}

struct Statistics {
  std::vector<double> median, rms, crps;  ///< by predictor
};

Statistics statistics_of(const std::vector<const Row*>& rows, std::size_t predictors) {
  Statistics statistics;
  std::vector<double> distances(rows.size());
  for (std::size_t p = 0; p < predictors; ++p) {
    double squares = 0.0, scores = 0.0;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      distances[k] = rows[k]->distances[p];
      squares += distances[k] * distances[k];
      scores += rows[k]->crps[p];
    }
    const auto count = static_cast<double>(rows.size());
    statistics.median.push_back(median(distances));
    statistics.rms.push_back(std::sqrt(squares / count));
    statistics.crps.push_back(scores / count);
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

std::optional<std::size_t> best_plain(const std::vector<double>& values, const Table& table) {
  std::optional<std::size_t> best;
  for (std::size_t p = 0; p < values.size(); ++p) {
    if (is_plain(table.columns[p].name) && !table.columns[p].model && (!best || values[p] < values[*best]))
      best = p;
  }
  return best;
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
  const std::size_t count = table.columns.size();
  const Statistics whole = statistics_of(all, count);
  const std::vector<Statistics> samples =
      by_cluster.size() < 2 ? std::vector<Statistics>{} : resampled(by_cluster, count, options);
  const auto by_median = best_plain(whole.median, table), by_rms = best_plain(whole.rms, table),
             by_crps = best_plain(whole.crps, table);
  const auto name_of = [&](const std::optional<std::size_t>& p) { return p ? table.columns[*p].name : ""; };
  ComparedQuantity result{.quantity = like.quantity,
                          .unit = like.unit,
                          .forecasts = static_cast<int>(rows.size()),
                          .clusters = static_cast<int>(by_cluster.size()),
                          .best_by_median = name_of(by_median),
                          .best_by_rms = name_of(by_rms),
                          .best_by_crps = std::isnan(whole.crps.front()) ? "" : name_of(by_crps)};
  const auto compared = [&](std::vector<double> Statistics::*statistic, std::size_t p,
                            const std::optional<std::size_t>& plain) {
    const std::vector<double>& values = whole.*statistic;
    ComparedStatistic one{.value = values[p], .to_first = {}, .to_plain = {}};
    if (p != 0) one.to_first = difference(values, samples, statistic, p, 0);
    if (plain && *plain != p) one.to_plain = difference(values, samples, statistic, p, *plain);
    return one;
  };
  for (std::size_t p = 0; p < count; ++p) {
    const Column& column = table.columns[p];
    ComparedPredictor predictor{.name = column.name, .is_plain = !column.model && is_plain(column.name)};
    predictor.median = compared(&Statistics::median, p, by_median);
    predictor.rms = compared(&Statistics::rms, p, by_rms);
    predictor.crps = compared(&Statistics::crps, p, by_crps);
    if (column.model) {
      predictor.missed = static_cast<int>(std::ranges::count_if(
          table.rows, [p](const auto& entry) { return std::isnan(entry.second.distances[p]); }));
    }
    result.predictors.push_back(std::move(predictor));
  }
  return result;
}

}  // namespace

void check_resampling(const ResamplingOptions& options) {
  constexpr int kFewest = 2, kMost = 1'000'000;  // whose errors have three digits
  require(options.replicates >= kFewest && options.replicates <= kMost, "replicates", options.replicates,
          fmt::format("{} to {}", kFewest, kMost));
}

std::vector<ComparedQuantity> compare_forecasts(std::span<const ForecastsOfModel> models,
                                                const ClusterOfCapture& clusters,
                                                const ResamplingOptions& options) {
  if (models.empty()) throw ArgumentError("there is no model to compare; one or more were expected");
  check_resampling(options);
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

std::optional<double> evidence_to_first(std::span<const ComparedModel> models, std::size_t model) {
  const std::optional<Evidence>&first = models.front().evidence, &own = models[model].evidence;
  if (!first || !own || first->values != own->values || first->compared != own->compared) return {};
  return own->log - first->log;
}

}  // namespace samara::identification
