#include "samara/identification/report/diagnostics_report.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <span>

#include <fmt/format.h>

#include "samara/base/rounded.h"
#include "samara/base/unit_labels.h"
#include "samara/identification/forecasts/trained_forecasts.h"

namespace samara::identification {

namespace {

constexpr const char* kBestMark = "*";

Json list(const std::vector<double>& values) {
  Json array = Json::array();
  for (const double value : values) array.push_back(number(value));
  return array;
}

Json json_of(const Profile& p) {
  return {{"name", p.name},
          {"shape", to_string(p.shape)},
          {"verdict", describe(p)},
          {"best", number(p.best)},
          {"best_cost", number(p.best_cost)},
          {"confidence", p.confidence},
          {"dispersion", number(p.dispersion)},
          {"degrees_of_freedom", number(p.degrees_of_freedom)},
          {"threshold", number(p.threshold)},
          {"interval", {number(p.interval_lower), number(p.interval_upper)}},
          {"ends", {to_string(p.lower_end), to_string(p.upper_end)}},
          {"values", list(p.values)},
          {"costs", list(p.costs)},
          {"better", p.better_value ? Json{{"value", number(p.better_value)}, {"cost", number(p.better_cost)}}
                                    : Json(nullptr)},
          {"solves", p.solves}};
}

Json json_of(const Identifiability& identifiability) {
  Json directions = Json::array();
  for (const InformationDirection& d : identifiability.directions) {
    directions.push_back({{"kind", to_string(d.kind)},
                          {"eigenvalue", number(d.eigenvalue)},
                          {"standard_error", number(d.standard_error)},
                          {"vector", column(d.vector)}});
  }
  return {{"names", identifiability.names},
          {"directions", directions},
          {"phrases", identifiability.phrases},
          {"undetermined_count", identifiability.undetermined_count}};
}

Json json_of(const Whiteness& whiteness) {
  Json series = Json::array();
  for (const SeriesWhiteness& s : whiteness.series) {
    series.push_back({{"capture", s.capture},
                      {"output", s.output},
                      {"count", s.count},
                      {"lag1", number(s.lag1)},
                      {"lags", s.lags},
                      {"statistic", number(s.statistic)},
                      {"p_value", number(s.p_value)}});
  }
  return {{"sentence", whiteness.sentence},       {"tested", whiteness.tested},
          {"rejected", whiteness.rejected},       {"median_lag1", number(whiteness.median_lag1)},
          {"p_value", number(whiteness.p_value)}, {"series", series}};
}

Json json_of(const PredictionScore& p) {
  Json object = {{"predictor", p.predictor},
                 {"quantity", p.quantity},
                 {"unit", p.unit},
                 {"captures", p.captures},
                 {"count", p.count},
                 {"median", number(p.median)},
                 {"rms", number(p.rms)},
                 {"largest", number(p.largest)},
                 {"best", p.best},
                 {"crps", number(p.crps)},
                 {"coverage50", number(p.coverage50)},
                 {"coverage90", number(p.coverage90)},
                 {"coverage90_error", number(p.coverage90_error)},
                 {"behind_best", number(p.behind_best)},
                 {"behind_best_error", number(p.behind_best_error)}};
  if (!p.capture.empty()) {
    object["capture"] = p.capture;
    object["file"] = p.file;
  }
  return object;
}

Json json_of(const NoiseLevel& level) {
  return {{"outputs", level.outputs},
          {"unit", level.unit},
          {"value", number(level.value)},
          {"standard_error", level.estimated ? number(level.standard_error()) : Json(nullptr)},
          {"degrees_of_freedom", number(level.degrees_of_freedom)},
          {"estimated", level.estimated}};
}

Json json_of(const GlobalSearch& search) {
  return {{"method", search.method},
          {"evaluations", search.evaluations},
          {"cost", number(search.cost)},
          {"seconds", number(search.seconds)}};
}

Json json_of(const Bootstrap& bootstrap) {
  return {{"replicates", bootstrap.replicates},
          {"converged", bootstrap.converged},
          {"seed", bootstrap.seed},
          {"standard_errors", list(bootstrap.standard_errors)}};
}

/// Draws of the coefficients, a list each: all, or so many evenly from all chains as pictures can show.
Json thinned_draws(const Posterior& posterior, std::size_t coefficients) {
  constexpr Eigen::Index kMost = 2000;
  const Eigen::Index draws = posterior.draws.rows();
  const Eigen::Index count = std::min(draws, kMost);
  Json columns = Json::array();
  for (std::size_t k = 0; k < coefficients; ++k) {
    Json column = Json::array();
    for (Eigen::Index i = 0; i < count; ++i)
      column.push_back(number(posterior.draws(i * draws / count, static_cast<Eigen::Index>(k))));
    columns.push_back(std::move(column));
  }
  return columns;
}

Json json_of(const Posterior& posterior, std::size_t coefficients) {
  Json unknowns = Json::array();
  for (const PosteriorUnknown& u : posterior.unknowns) {
    unknowns.push_back({{"name", u.name},
                        {"mean", number(u.mean)},
                        {"deviation", number(u.deviation)},
                        {"lower", number(u.lower)},
                        {"median", number(u.median)},
                        {"upper", number(u.upper)},
                        {"rhat", number(u.rhat)},
                        {"effective", number(u.effective)}});
  }
  return {{"draws", posterior.draws.rows()},
          {"chains", posterior.chains},
          {"seed", posterior.seed},
          {"acceptance", number(posterior.acceptance)},
          {"divergences", posterior.divergences},
          {"settled", posterior.is_settled()},
          {"unknowns", unknowns},
          {"coefficient_draws", thinned_draws(posterior, coefficients)}};
}

void add_posterior_text(const FitResult& result, std::back_insert_iterator<std::string> out) {
  if (!result.posterior) return;
  const Posterior& posterior = *result.posterior;
  double rhat = 0.0, effective = posterior.unknowns.front().effective;
  for (const PosteriorUnknown& u : posterior.unknowns) {
    rhat = std::max(rhat, u.rhat);
    effective = std::min(effective, u.effective);
  }
  fmt::format_to(out,
                 "posterior: {} draws in {} chains, R-hat at most {:.3f}, {:.0f} effective draws or more, {} "
                 "divergences\n",
                 posterior.draws.rows(), posterior.chains, rhat, effective, posterior.divergences);
  for (std::size_t k = 0; k < result.coefficients.size(); ++k) {
    const PosteriorUnknown& u = posterior.unknowns[k];
    fmt::format_to(out, "  {}: {:.5g}, 95 % from {:.5g} to {:.5g}\n", u.name, u.median, u.lower, u.upper);
  }
}

void add_bootstrap_text(const FitResult& result, std::back_insert_iterator<std::string> out) {
  if (!result.bootstrap) return;
  fmt::format_to(out, "errors from {} fits with clusters weighted at random:", result.bootstrap->replicates);
  for (std::size_t k = 0; k < result.coefficients.size(); ++k) {
    const double error = result.bootstrap->standard_errors[k];
    fmt::format_to(out, "{} {} {}", k == 0 ? "" : ",", result.coefficients[k].name,
                   std::isfinite(error) ? fmt::format("+- {:.2g}", error) : "-");
  }
  fmt::format_to(out, "\n");
}

/// Scores in a row that are of the same quantity, and of the same capture or of all.
std::vector<std::span<const PredictionScore>> groups_of(const std::vector<PredictionScore>& scores) {
  std::vector<std::span<const PredictionScore>> groups;
  for (std::size_t first = 0; first < scores.size();) {
    std::size_t end = first;
    while (end < scores.size() && scores[end].quantity == scores[first].quantity &&
           scores[end].capture == scores[first].capture && scores[end].file == scores[first].file)
      ++end;
    groups.push_back(std::span(scores).subspan(first, end - first));
    first = end;
  }
  return groups;
}

std::string shown(const PredictionScore& score, double value) {
  return score.count > 0 ? fmt::format("{:.4g}", value) : "-";
}

/// Where a plain baseline that says as much is better than the model of a group, which one is.
std::string better_baseline(std::span<const PredictionScore> group) {
  const PredictionScore& model = group.front();
  const PredictionScore* best = nullptr;
  for (const PredictionScore& p : group) {
    if (p.count >= model.count && is_plain(p.predictor) && (best == nullptr || p.median < best->median))
      best = &p;
  }
  if (best == nullptr || model.count == 0 || model.median <= best->median) return {};
  const std::string unit = unit_suffix(model.unit);
  return fmt::format("the {} predicts {} better than the model: median {:.4g}{}, not {:.4g}{}\n",
                     best->predictor, model.quantity, best->median, unit, model.median, unit);
}

/// A row a capture and quantity; with the file of the capture where others have its id.
void add_capture_predictions(const FitResult& result, std::back_insert_iterator<std::string> out) {
  const auto groups = groups_of(result.capture_predictions);
  if (groups.empty()) return;
  std::map<std::string, std::set<std::string>> files;  // of each id
  for (const auto& group : groups) files[group.front().capture].insert(group.front().file);
  const auto name_of = [&](const PredictionScore& p) {
    return files.at(p.capture).size() < 2 ? p.capture : fmt::format("{} ({})", p.capture, p.file);
  };
  std::size_t longest = 20;
  for (const auto& group : groups) longest = std::max(longest, name_of(group.front()).size());
  fmt::format_to(out, "\n{:<{}}  {:<42}", "median of capture", longest, "prediction of");
  for (const PredictionScore& p : groups.front()) fmt::format_to(out, "  {:>21}", p.predictor);
  fmt::format_to(out, "\n");
  for (const auto& group : groups) {
    fmt::format_to(out, "{:<{}}  {:<42}", name_of(group.front()), longest,
                   with_unit(group.front().quantity, group.front().unit));
    for (const PredictionScore& first : groups.front()) {
      const auto p = std::ranges::find(group, first.predictor, &PredictionScore::predictor);
      fmt::format_to(out, "  {:>21}",
                     p == group.end() ? "- " : shown(*p, p->median) + (p->best ? kBestMark : " "));
    }
    fmt::format_to(out, "\n");
  }
}

/// Scores as distributions, where training captures showed the errors of predictors.
void add_forecast_table(const FitResult& result, std::back_insert_iterator<std::string> out) {
  const auto is_known = [](const PredictionScore& p) { return std::isfinite(p.crps); };
  if (std::ranges::none_of(result.predictions, is_known)) return;
  fmt::format_to(out, "\n{:<42} {:<22} {:>12} {:>8} {:>8}  {}\n", "forecast of", "by", "crps", "in 50 %",
                 "in 90 %", "less best baseline");
  for (const PredictionScore& p : result.predictions) {
    if (!is_known(p)) continue;
    fmt::format_to(out, "{:<42} {:<22} {:>12.4g} {:>6.0f} % {:>6.0f} %  {}\n", with_unit(p.quantity, p.unit),
                   p.predictor, p.crps, 100.0 * p.coverage50, 100.0 * p.coverage90,
                   std::isfinite(p.behind_best_error)
                       ? fmt::format("{:.3g} +- {:.2g}", p.behind_best, p.behind_best_error)
                       : fmt::format("{:.3g}", p.behind_best));
  }
}

void add_prediction_table(const FitResult& result, std::back_insert_iterator<std::string> out) {
  if (result.predictions.empty()) return;
  fmt::format_to(out, "\n{:<42} {:<22} {:>12} {:>13} {:>9} {:>9}\n", "prediction of", "by", "median", "rms",
                 "captures", "values");
  std::string losses;
  for (const auto& group : groups_of(result.predictions)) {
    for (const PredictionScore& p : group) {
      fmt::format_to(out, "{:<42} {:<22} {:>12}{} {:>12} {:>9} {:>9}\n", with_unit(p.quantity, p.unit),
                     p.predictor, shown(p, p.median), p.best ? kBestMark : " ", shown(p, p.rms), p.captures,
                     p.count);
    }
    losses += better_baseline(group);
  }
  fmt::format_to(out, "{} the best by its median\n{}", kBestMark, losses);
  add_forecast_table(result, out);
  add_capture_predictions(result, out);
}

void add_noise_text(const FitResult& result, std::back_insert_iterator<std::string> out) {
  for (const NoiseLevel& level : result.noise) {
    const std::string unit = unit_suffix(level.unit);
    const std::string outputs = fmt::format("{}", fmt::join(level.outputs, ", "));
    if (level.estimated) {
      fmt::format_to(out, "noise of {}: {}{}, estimated\n", outputs,
                     with_error(level.value, level.standard_error()), unit);
    } else {
      fmt::format_to(out, "noise of {}: taken to be {:.3g}{}\n", outputs, level.value, unit);
    }
  }
  if (!result.noise.empty())
    fmt::format_to(out, "noise levels were estimated in {} round{}\n", result.noise_rounds,
                   result.noise_rounds == 1 ? "" : "s");
}

}  // namespace

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit == "1" ? name : fmt::format("{} [{}]", name, unit);
}

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json number(const std::optional<double>& value) {
  return value ? number(*value) : Json(nullptr);
}

Json column(const Eigen::Ref<const Eigen::VectorXd>& values) {
  Json array = Json::array();
  for (const double value : values) array.push_back(number(value));
  return array;
}

void add_diagnostics(const FitResult& result, Json& object) {
  object["profiles"] = Json::array();
  for (const Profile& p : result.profiles) object["profiles"].push_back(json_of(p));
  object["identifiability"] = result.identifiability ? json_of(*result.identifiability) : Json(nullptr);
  object["whiteness"] = result.whiteness ? json_of(*result.whiteness) : Json(nullptr);
  object["predictions"] = Json::array();
  for (const PredictionScore& p : result.predictions) object["predictions"].push_back(json_of(p));
  object["capture_predictions"] = Json::array();
  for (const PredictionScore& p : result.capture_predictions)
    object["capture_predictions"].push_back(json_of(p));
  object["bootstrap"] = result.bootstrap ? json_of(*result.bootstrap) : Json(nullptr);
  object["posterior"] =
      result.posterior ? json_of(*result.posterior, result.coefficients.size()) : Json(nullptr);
  object["integration_shift"] = number(result.integration_shift);
  object["noise"] = Json::array();
  for (const NoiseLevel& level : result.noise) object["noise"].push_back(json_of(level));
  object["noise_rounds"] = result.noise_rounds;
  object["global_search"] = result.global_search ? json_of(*result.global_search) : Json(nullptr);
}

void add_diagnostics_text(const FitResult& result, std::string& text) {
  const auto out = std::back_inserter(text);
  add_bootstrap_text(result, out);
  add_posterior_text(result, out);
  add_prediction_table(result, out);
  if (result.identifiability) {
    for (const std::string& phrase : result.identifiability->phrases)
      fmt::format_to(out, "determined by the captures: {}\n", phrase);
  }
  if (result.whiteness) fmt::format_to(out, "residuals: {}\n", result.whiteness->sentence);
  add_noise_text(result, out);
  if (result.integration_shift) {
    fmt::format_to(out,
                   "steps of half the length would move no coefficient by more than {:.2g} standard errors\n",
                   *result.integration_shift);
  }
  if (result.global_search) {
    const GlobalSearch& g = *result.global_search;
    fmt::format_to(out, "search of the box by {}: {} points, least cost {:.6g} with segments not joined\n",
                   g.method, g.evaluations, g.cost);
  }
}

}  // namespace samara::identification
