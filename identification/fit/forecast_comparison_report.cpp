#include "samara/identification/fit/forecast_comparison_report.h"

#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "samara/identification/report/diagnostics_report.h"

namespace samara::identification {

namespace {

using TextEnd = std::back_insert_iterator<std::string>;

Json json_of(const ForecastDifference& difference) {
  return {{"value", number(difference.value)}, {"error", number(difference.error)}};
}

Json json_of(const ComparedStatistic& statistic) {
  return {{"value", number(statistic.value)},
          {"to_first", json_of(statistic.to_first)},
          {"to_plain", json_of(statistic.to_plain)}};
}

Json json_of(const ComparedQuantity& quantity) {
  Json predictors = Json::array();
  for (const ComparedPredictor& p : quantity.predictors) {
    predictors.push_back({{"name", p.name},
                          {"is_plain", p.is_plain},
                          {"median", json_of(p.median)},
                          {"rms", json_of(p.rms)},
                          {"crps", json_of(p.crps)},
                          {"missed", p.missed}});
  }
  return {{"quantity", quantity.quantity},
          {"unit", quantity.unit},
          {"forecasts", quantity.forecasts},
          {"clusters", quantity.clusters},
          {"best_plain_by_median", quantity.best_by_median},
          {"best_plain_by_rms", quantity.best_by_rms},
          {"best_plain_by_crps", quantity.best_by_crps},
          {"predictors", predictors}};
}

Json json_of(std::span<const ComparedModel> models, std::size_t k) {
  const ComparedModel& m = models[k];
  Json evidence;  // null: none
  if (m.evidence) {
    const std::optional<double> to_first = evidence_to_first(models, k);
    evidence = {{"log", m.evidence->log},
                {"to_first", to_first ? Json(*to_first) : Json()},
                {"values", m.evidence->values},
                {"unknowns", m.evidence->unknowns},
                {"noise_factor", m.evidence->noise_factor}};
  }
  return {{"name", m.name},
          {"source", m.source},
          {"model", m.model},
          {"coefficients", m.coefficients},
          {"evidence", evidence},
          {"no_evidence", m.no_evidence},
          {"no_forecast", m.no_forecast}};
}

/// What the captures say of the models as a whole.
void add_evidence(const std::vector<ComparedModel>& models, TextEnd out) {
  fmt::format_to(out, "\n{:<28} {:>12} {:>24}\n", "ln evidence, all captures", "", "less the first");
  for (std::size_t k = 0; k < models.size(); ++k) {
    const ComparedModel& m = models[k];
    if (!m.evidence) {
      fmt::format_to(out, "  {:<26} none: {}\n", m.name, m.no_evidence);
      continue;
    }
    const std::optional<double> to_first = evidence_to_first(models, k);
    fmt::format_to(out, "  {:<26} {:>12.2f} {:>23}\n", m.name, m.evidence->log,
                   k == 0     ? ""
                   : to_first ? fmt::format("{:+.2f}", *to_first)
                              : "of other values");
  }
}

/// As far as its error leaves it, marked where it is clear.
std::string shown(const ForecastDifference& difference) {
  if (std::isnan(difference.value)) return "- ";
  if (std::isnan(difference.error)) return fmt::format("{:+.3g}  ", difference.value);
  return fmt::format("{:+.2g} +- {:.2g}{}", difference.value, difference.error,
                     difference.is_clear() ? "*" : " ");
}

/// One statistic of every predictor.
void add_rows(const ComparedQuantity& quantity, const char* name,
              ComparedStatistic ComparedPredictor::*statistic, const std::string& best_plain, TextEnd out) {
  fmt::format_to(out, "{:<28} {:>12} {:>24} {:>24}\n", name, "", "less the first",
                 best_plain.empty() ? "" : "less the best plain");
  for (const ComparedPredictor& p : quantity.predictors) {
    const ComparedStatistic& value = p.*statistic;
    const bool is_best_plain = p.is_plain && p.name == best_plain;
    fmt::format_to(out, "  {:<26} {:>12} {:>24} {:>24}\n", p.name,
                   std::isnan(value.value) ? "-" : fmt::format("{:.4g}", value.value), shown(value.to_first),
                   is_best_plain ? "best plain " : shown(value.to_plain));
  }
}

void add_quantity(const ModelComparison& comparison, const ComparedQuantity& quantity, TextEnd out) {
  fmt::format_to(out, "\n{}: {} forecasts of {} clusters\n", with_unit(quantity.quantity, quantity.unit),
                 quantity.forecasts, quantity.clusters);
  add_rows(quantity, "median", &ComparedPredictor::median, quantity.best_by_median, out);
  add_rows(quantity, "rms", &ComparedPredictor::rms, quantity.best_by_rms, out);
  if (!std::isnan(quantity.predictors.front().crps.value))
    add_rows(quantity, "crps", &ComparedPredictor::crps, quantity.best_by_crps, out);
  for (const ComparedPredictor& p : quantity.predictors) {
    if (p.missed > 0)
      fmt::format_to(out, "{} says nothing of {} forecasts that others make; they are left out for all\n",
                     p.name, p.missed);
  }
  for (std::size_t m = 0; m < comparison.models.size(); ++m) {
    const ComparedPredictor& p = quantity.predictors[m];
    if (p.median.to_plain.value > 0.0 && p.rms.to_plain.value > 0.0)
      fmt::format_to(out, "{} predicts worse than the best plain baseline\n", p.name);
  }
}

}  // namespace

std::string comparison_json(const ModelComparison& comparison) {
  Json models = Json::array(), quantities = Json::array();
  for (std::size_t k = 0; k < comparison.models.size(); ++k) models.push_back(json_of(comparison.models, k));
  for (const ComparedQuantity& q : comparison.quantities) quantities.push_back(json_of(q));
  const Json object = {{"schema", "samara-compare/1"},
                       {"by", comparison.by},
                       {"folds", comparison.folds},
                       {"clusters", comparison.clusters},
                       {"models", models},
                       {"quantities", quantities},
                       {"warnings", comparison.warnings.sentences()},
                       {"seconds", comparison.seconds}};
  // Names come from files in any encoding.
  return object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string comparison_text(const ModelComparison& comparison) {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "forecasts of captures left out, {} folds by \"{}\"\n", comparison.folds,
                 comparison.by);
  for (const ComparedModel& m : comparison.models)
    fmt::format_to(out, "  {:<26} {} with {} coefficient{}\n", m.name, m.source, m.coefficients,
                   m.coefficients == 1 ? "" : "s");
  for (const ComparedQuantity& q : comparison.quantities) add_quantity(comparison, q, out);
  add_evidence(comparison.models, out);
  fmt::format_to(out, "* more than two errors off zero; errors are of clusters drawn anew\n{:.3g} s\n",
                 comparison.seconds);
  return text;
}

}  // namespace samara::identification
