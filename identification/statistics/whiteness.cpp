#include "samara/identification/statistics/whiteness.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/identification/statistics/quantiles.h"

namespace samara::identification {

namespace {

constexpr int kFewest = 8;
constexpr int kMostLags = 10;
constexpr double kLevel = 0.05;
/// A grid with more places than this many per residual is none: the times are not those of a camera.
constexpr double kSparsestGrid = 1000.0;

/// The residuals that are there, with their places on the grid of frames.
struct Series {
  std::vector<long> places;
  std::vector<double> values;
};

Series on_grid(std::span<const double> times, std::span<const double> residuals) {
  std::vector<double> intervals;
  for (std::size_t k = 1; k < times.size(); ++k) intervals.push_back(times[k] - times[k - 1]);
  const double interval = intervals.empty() ? 1.0 : median(intervals);
  const bool is_grid =
      interval > 0.0 && !times.empty() &&
      (times.back() - times.front()) / interval < kSparsestGrid * static_cast<double>(times.size());
  Series series;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (!std::isfinite(residuals[k])) continue;
    const auto place = is_grid ? std::lround((times[k] - times.front()) / interval) : static_cast<long>(k);
    // Two frames that round to one place are neighbours all the same.
    series.places.push_back(series.places.empty() ? place : std::max(place, series.places.back() + 1));
    series.values.push_back(residuals[k]);
  }
  return series;
}

/// Pulls values beyond three standard deviations in to there.
void tame(std::vector<double>& values) {
  std::vector<double> sizes;
  for (const double value : values) sizes.push_back(std::abs(value));
  const double bound = 3.0 * 1.4826 * median(sizes);
  if (bound <= 0.0) return;
  for (double& value : values) value = std::clamp(value, -bound, bound);
}

/// Mean product of residuals `lag` frames apart, and their number.
struct LagProduct {
  double sum = 0.0;
  int pairs = 0;
};

LagProduct lag_product(const Series& series, int lag) {
  LagProduct product;
  std::size_t partner = 0;
  for (std::size_t k = 0; k < series.places.size(); ++k) {
    while (partner < series.places.size() && series.places[partner] < series.places[k] + lag) ++partner;
    if (partner == series.places.size()) break;
    if (series.places[partner] != series.places[k] + lag) continue;
    product.sum += series.values[k] * series.values[partner];
    ++product.pairs;
  }
  return product;
}

void check(std::span<const double> times, std::span<const double> residuals, int lags) {
  if (times.size() != residuals.size()) {
    throw ArgumentError(
        fmt::format("{} times have {} residuals; as many were expected", times.size(), residuals.size()));
  }
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (std::isfinite(times[k]) && (k == 0 || times[k] >= times[k - 1])) continue;
    throw ArgumentError(fmt::format(
        "time {} of the residuals is {}; finite times that do not go back were expected", k, times[k]));
  }
  if (lags < 0) throw ArgumentError(fmt::format("lags is {}; at least 0 was expected", lags));
}

/// More rejections than independent residuals would give in 99 of 100 cases.
bool too_many(int rejected, int tested) {
  if (rejected == 0) return false;
  return binomial_tail(tested, kLevel, rejected - 1) < 0.01;
}

/// By a power of two: correlations stay as they are, and squares are numbers whatever the residuals.
void scale_to_one(std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  if (!(largest > 0.0 && std::isfinite(largest))) return;
  const int exponent = std::ilogb(largest);
  for (double& value : values) value = std::ldexp(value, -exponent);
}

std::string sentence_of(const Whiteness& w) {
  if (w.tested == 0) return "there are too few residuals to tell whether they are independent";
  const std::string found = fmt::format(
      "{} of {} residual series {} not independent from frame to frame at the 5 % level (median "
      "lag-1 correlation {:.2f})",
      w.rejected, w.tested, w.tested == 1 && w.rejected == 1 ? "is" : "are", w.median_lag1);
  const bool pooled = w.p_value && *w.p_value < 0.01;
  if (!too_many(w.rejected, w.tested) && !pooled) return found + ": as chance has it";
  if (w.median_lag1 <= 0.0) return found + ": the model or the tracking leaves something in them";
  const double factor = std::sqrt((1.0 + w.median_lag1) / std::max(1.0 - w.median_lag1, 1e-3));
  return fmt::format(
      "{}: the model or the tracking leaves something in them, and naive errors are too small "
      "by a factor of about {:.2g}",
      found, factor);
}

}  // namespace

SeriesWhiteness series_whiteness(std::span<const double> times, std::span<const double> residuals, int lags) {
  check(times, residuals, lags);
  Series series = on_grid(times, residuals);
  SeriesWhiteness result;
  result.count = static_cast<int>(series.values.size());
  if (series.values.empty()) return result;
  tame(series.values);
  scale_to_one(series.values);
  const auto n = static_cast<double>(series.values.size());
  double variance = 0.0;
  for (const double value : series.values) variance += value * value / n;
  result.lags = lags > 0 ? lags : std::clamp(result.count / 5, 1, kMostLags);
  if (variance <= 0.0) return result;

  int used = 0;
  for (int lag = 1; lag <= result.lags; ++lag) {
    const LagProduct product = lag_product(series, lag);
    if (product.pairs == 0) continue;
    const double correlation = product.sum / product.pairs / variance;
    if (lag == 1) result.lag1 = correlation;
    result.statistic += (n + 2.0) / n * product.pairs * correlation * correlation;
    ++used;
  }
  result.lags = used;
  if (result.count >= kFewest && used > 0) result.p_value = chi_squared_tail(used, result.statistic);
  return result;
}

Whiteness pool_whiteness(std::vector<SeriesWhiteness> series) {
  Whiteness result{.series = std::move(series)};
  std::vector<double> lag1;
  double statistic = 0.0;
  int lags = 0;
  for (const SeriesWhiteness& s : result.series) {
    if (!s.p_value) continue;
    ++result.tested;
    result.rejected += *s.p_value < kLevel ? 1 : 0;
    lag1.push_back(s.lag1);
    statistic += s.statistic;
    lags += s.lags;
  }
  if (result.tested > 0) {
    result.median_lag1 = median(lag1);
    result.p_value = chi_squared_tail(lags, statistic);
  }
  result.sentence = sentence_of(result);
  return result;
}

}  // namespace samara::identification
