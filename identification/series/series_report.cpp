#include "samara/identification/series/series_report.h"

#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "samara/base/rounded.h"
#include "samara/base/unit_labels.h"
#include "samara/identification/report/diagnostics_report.h"
#include "samara/identification/report/fit_report.h"

namespace samara::identification {

namespace {

Json json_of(const SeriesCoefficient& c) {
  Json basis = Json::array();
  for (const InstantBasis b : c.basis) basis.push_back(to_string(b));
  return {{"name", c.name},
          {"unit", c.unit},
          {"scale", number(c.scale)},
          {"constant", number(c.constant)},
          {"values", column(c.values)},
          {"standard_errors", column(c.standard_errors)},
          {"shares", column(c.shares)},
          {"basis", basis}};
}

std::string value_text(const SeriesCoefficient& c, Eigen::Index k) {
  const double error = c.standard_errors[k];
  return std::isnan(error) ? fmt::format("{:.5g} ?", c.values[k]) : with_error(c.values[k], error);
}

void add_table(const CoefficientSeries& series, std::back_insert_iterator<std::string> out) {
  fmt::format_to(out, "\n{:>10}", series.time_unit == "1" ? "t" : fmt::format("t [{}]", series.time_unit));
  for (const SeriesCoefficient& c : series.coefficients) {
    fmt::format_to(out, " {:>24} {:>6} {:>10}",
                   c.unit == "1" ? c.name : fmt::format("{} [{}]", c.name, c.unit), "own", "rests on");
  }
  for (Eigen::Index k = 0; k < series.instants.size(); ++k) {
    fmt::format_to(out, "\n{:>10.5g}", series.instants[k]);
    for (const SeriesCoefficient& c : series.coefficients) {
      fmt::format_to(out, " {:>24} {:>6.2f} {:>10}", value_text(c, k), c.shares[k],
                     to_string(c.basis[static_cast<std::size_t>(k)]));
    }
  }
  fmt::format_to(out, "\n");
}

}  // namespace

std::string series_json(const CoefficientSeries& series) {
  Json coefficients = Json::array();
  for (const SeriesCoefficient& c : series.coefficients) coefficients.push_back(json_of(c));
  Json trials = Json::array();
  for (const SmoothnessTrial& trial : series.trials) {
    trials.push_back({{"factor", trial.factor},
                      {"criterion", number(trial.criterion)},
                      {"effective", number(trial.effective)}});
  }
  const Json object = {{"schema", "samara-series/1"},
                       {"status", to_string(series.status)},
                       {"message", series.message},
                       {"warnings", series.warnings.sentences()},
                       {"model", series.model},
                       {"time_unit", series.time_unit},
                       {"joined", series.joined},
                       {"windows", series.spans},
                       {"instants", column(series.instants)},
                       {"series", coefficients},
                       {"factor", number(series.factor)},
                       {"trials", trials},
                       {"effective", number(series.effective)},
                       {"correlation_factor", series.correlation_factor},
                       {"replay", series.replay},
                       {"constant", Json::parse(fit_json(series.constant))},
                       {"fit", Json::parse(fit_json(series.fit))}};
  return object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string series_text(const CoefficientSeries& series) {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "series of {} in {} {} spans: {}\n", series.model, series.spans,
                 series.joined ? "joined" : "sliding", series.message);
  if (series.coefficients.empty()) return text;
  add_table(series, out);
  fmt::format_to(
      out,
      "own: the share of a value that the frames around its instant determine; the rest comes from "
      "its neighbours\n");
  fmt::format_to(out, "{:.1f} free values of {} in use", series.effective,
                 series.instants.size() * static_cast<Eigen::Index>(series.coefficients.size()));
  if (series.factor) {
    fmt::format_to(out, "; differences of {:.2g} of the constant value, the likeliest of {} tried",
                   *series.factor, series.trials.size());
  }
  fmt::format_to(out, "\n");
  for (std::size_t k = 0; k < series.fit.residuals.size(); ++k) {
    const OutputRms& r = series.fit.residuals[k];
    fmt::format_to(out, "rms of {}: {:.4g}{}, with constant coefficients {:.4g}\n", r.output, r.rms,
                   unit_suffix(r.unit), series.constant.residuals[k].rms);
  }
  const auto moved = std::ranges::max_element(series.coefficients, {}, &SeriesCoefficient::integration_shift);
  if (moved->integration_shift) {
    fmt::format_to(out, "steps of half the length would move no value by more than {:.2g} standard errors\n",
                   *moved->integration_shift);
  }
  for (const Warning& warning : series.warnings) fmt::format_to(out, "warning: {}\n", warning.sentence);
  return text;
}

}  // namespace samara::identification
