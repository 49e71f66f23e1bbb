#include "samara/identification/series/coefficient_series.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"
#include "samara/base/text.h"
#include "samara/base/unit_labels.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fit_warnings.h"
#include "samara/identification/series/series_fits.h"
#include "samara/identification/series/series_knots.h"
#include "samara/identification/series/series_spans.h"
#include "samara/models/trajectories/reference_trajectories.h"
#include "samara/models/trajectories/step_trajectories.h"

namespace samara::identification {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Sizes of a difference between neighbours, over the constant value, that are tried: from no change that
/// could be seen to any.
constexpr std::array kFactors = {1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0};

/// @throws ArgumentError unless the coefficient is a free parameter with one value.
void check_coefficient(const models::ModelInfo& model, const FitOptions& options, const std::string& name) {
  std::vector<std::string> known;
  for (const models::ParameterInfo& parameter : model.parameters) known.push_back(parameter.name);
  if (std::ranges::count(known, name) == 0) {
    throw ArgumentError(
        fmt::format("series: model \"{}\" has no parameter \"{}\" that could change in time{}", model.name,
                    name, suggestion(name, known)));
  }
  if (options.unknowns.fixed.contains(name) || options.unknowns.known.contains(name) ||
      std::ranges::count(options.unknowns.per_capture, name) > 0) {
    throw ArgumentError(fmt::format(
        "series: \"{}\" is fixed, known or of each capture's own; a coefficient of the box was expected",
        name));
  }
  if (!options.unknowns.box.contains(name)) {
    throw ArgumentError(
        fmt::format("series: \"{}\" has no interval in the box, which is to hold at every instant", name));
  }
}

/// @throws ArgumentError for what has no meaning for a series.
void check_combination(const FitOptions& options, const SeriesOptions& series) {
  if (const std::vector<std::string> measured = measurement_names(options); !measured.empty()) {
    throw ArgumentError(fmt::format(
        "\"{}\" is unknown, and a series takes clocks and sensors as they are; a config without delay and "
        "gain was expected",
        measured.front()));
  }
  if (options.uncertainty.profiles) {
    throw ArgumentError(
        "profiles are of coefficients that stay constant; either profiles or a series was expected");
  }
  if (options.uncertainty.posterior.samples > 0) {
    throw ArgumentError(
        fmt::format("posterior asks for {} samples, and those are of coefficients that stay constant; either "
                    "a posterior or a "
                    "series was expected",
                    options.uncertainty.posterior.samples));
  }
  if (options.uncertainty.bootstrap.replicates > 0) {
    throw ArgumentError(fmt::format(
        "bootstrap asks for {} replicates, and the errors of a series are not made of them; either a "
        "bootstrap or a series was expected",
        options.uncertainty.bootstrap.replicates));
  }
  if (options.compared.stride) {
    throw ArgumentError(
        "stride cuts captures into spans, and a series follows each of them as a whole; either a stride or "
        "a series was expected");
  }
  if (series.stride && options.segments.length) {
    throw ArgumentError(fmt::format(
        "segments of {} s and a series.stride: spans that slide are the segments, unjoined; one of "
        "the two was expected",
        *options.segments.length));
  }
  if (series.stride && options.noise.estimated) {
    throw ArgumentError(
        "noise is not estimated where spans slide, since frames count in several of them; loss scales, or "
        "no series.stride, were expected");
  }
}

std::unique_ptr<models::TrajectoryFamily> constant_family(const std::shared_ptr<const models::Model>& model,
                                                          const FitOptions& options) {
  return options.solver.step
             ? step_trajectories(model, options.unknowns.fixed, options.unknowns.box, *options.solver.step)
             : reference_trajectories(model, options.unknowns.fixed, options.unknowns.box);
}

/// A fit of the spans.
FitOptions options_of_spans(const FitOptions& options, const SeriesSpans& spans,
                            const SeriesOptions& series) {
  FitOptions result = options;
  result.compared.span.reset();
  if (!spans.joined) {
    result.segments.length = std::numeric_limits<double>::max();
  } else if (!result.segments.length) {
    result.segments.length = series.span;
  }
  // A frame in m spans counts m times: in the mean over all frames once.
  const double scale = std::sqrt(spans.overlap);
  result.loss.length_scale *= scale;
  for (auto& [name, value] : result.loss.scales) value *= scale;
  result.loss.attitude_scale *= scale;
  return result;
}

/// The fit of the best smoothness.
struct Chosen {
  double factor = 1.0;
  FitResult fit = {};
  SeriesFits::Judgement judgement = {};
};

Chosen choose(SeriesFits& fits, std::vector<SmoothnessTrial>& trials) {
  Chosen best;
  int worse = 0;
  for (const double factor : kFactors) {
    FitResult result = fits.fit_with(factor);
    if (result.status == Termination::failed) {
      trials.push_back({factor, kNaN, 0.0});
      if (best.fit.status == Termination::failed) best.fit = std::move(result);
      continue;
    }
    SeriesFits::Judgement judgement = fits.judge(result, factor);
    trials.push_back({factor, judgement.criterion, judgement.effective});
    // Of a fit that cannot be judged the criterion is NaN: any other is better, and it ends no search.
    const bool is_judged = !std::isnan(best.judgement.criterion);
    const bool first =
        best.fit.status == Termination::failed || (!is_judged && !std::isnan(judgement.criterion));
    if (first || judgement.criterion < best.judgement.criterion) {
      best = {factor, std::move(result), std::move(judgement)};
      worse = 0;
    } else if (is_judged && ++worse == 2) {
      break;
    }
  }
  return best;
}

/// Costs in units of noise compare only where these are the same: levels are found with one smoothness and
/// held while the likeliest is looked for, until it is the one that they were found with. The first is rough,
/// since what a smooth series misses would count as noise.
Chosen choose_with_levels(SeriesFits& fits, const FitResult& constant, std::vector<SmoothnessTrial>& trials) {
  constexpr double kRough = 0.1;
  constexpr int kRounds = 5;
  double factor = kRough;
  Chosen found;
  for (int round = 0; round < kRounds; ++round) {
    found = {factor, fits.fit_with_levels(factor), {}};
    fits.hold_levels(found.fit.status == Termination::failed ? constant : found.fit);
    trials.clear();
    Chosen best = choose(fits, trials);
    if (found.fit.status == Termination::failed) {
      if (best.fit.status == Termination::failed) return best;
    } else {
      found.judgement = fits.judge(found.fit, factor);
      if (best.factor == factor) return found;
    }
    factor = best.factor;
  }
  found.fit.warnings.add(
      WarningKind::series,
      "the likeliest smoothness and the noise levels that belong to it still changed each other in the last "
      "round");
  return found;
}

/// By how much errors grow where residuals are correlated; whiteness.h.
double growth_of_errors(const FitResult& result) {
  if (!result.whiteness || !result.whiteness->p_value || *result.whiteness->p_value > 0.05) return 1.0;
  const double r = std::clamp(result.whiteness->median_lag1, 0.0, 0.95);
  return std::sqrt((1.0 + r) / (1.0 - r));
}

/// Everything a simulation from the first instant on needs besides the series.
void add_replay(const models::ModelInfo& model, const FitResult& result, const SeriesKnots& knots,
                const FitOptions& options, CoefficientSeries& series) {
  std::map<std::string, std::string> units;
  for (const models::ParameterInfo& parameter : model.parameters) units[parameter.name] = parameter.unit;
  for (const models::StateInfo& state : model.states) units[state.name + "(0)"] = state.unit;
  const CaptureFit& first = *std::ranges::min_element(result.captures, {}, &CaptureFit::start);
  const bool is_late = first.start > knots.instants[0];
  // The state of a running mean of frames is before the first of them.
  const auto holds_at_first_frame = [&](std::string_view name) {
    return (options.compared.averaged_frames == 1 && !is_late) || !name.ends_with("(0)");
  };
  series.replay = options.unknowns.fixed;
  for (const Coefficient& c : result.coefficients) {
    if (units.contains(c.name) && std::ranges::count(knots.coefficients, c.name) == 0)
      series.replay[c.name] = c.value;
  }
  if (is_late) {
    const std::string unit = unit_suffix(series.time_unit);
    std::erase_if(series.replay, [&](const auto& value) { return !holds_at_first_frame(value.first); });
    series.warnings.add(
        WarningKind::series,
        fmt::format(
            "the series begins at {:.6g}{}, and nothing is compared before {:.6g}{}: it has no initial "
            "values for a replay",
            knots.instants[0], unit, first.start, unit));
  }
  for (const auto& [name, value] : first.known) {
    if (holds_at_first_frame(name)) series.replay[name] = value;
  }
  for (const Nuisance& n : first.nuisances) {
    if (units.contains(n.name) && holds_at_first_frame(n.name)) series.replay[n.name] = n.value;
    constexpr std::string_view kOffset = "offset of ";
    if (!n.name.starts_with(kOffset)) continue;
    const std::string start = n.name.substr(kOffset.size()) + "(0)";
    if (holds_at_first_frame(start)) series.replay[start] += n.value;
  }
  for (const auto& [name, value] : series.replay) series.replay_units[name] = units.at(name);
}

void add_series_warnings(const FitOptions& options, CoefficientSeries& series) {
  series.warnings = series.fit.warnings;
  for (const SeriesCoefficient& c : series.coefficients) {
    // Of a series priors say what its mean is.
    const auto prior = options.priors.coordinates.find(c.name);
    if (prior == options.priors.coordinates.end() || c.values.size() == 1) continue;
    const double away = (c.values.mean() - prior->second.mean) / standard_deviation(prior->second);
    add_prior_warning("the mean of " + c.name, c.values.mean(), std::abs(away), series.warnings);
  }
  if (series.factor == kFactors.front()) {
    series.warnings.add(
        WarningKind::series,
        "the captures show no change of the coefficients in time: the smoothest series that was tried is the "
        "likeliest");
  }
  if (series.factor == kFactors.back()) {
    series.warnings.add(
        WarningKind::series,
        "the roughest series that was tried is the likeliest: values at neighbouring instants are not held "
        "together, and a shorter span may be needed");
  }
  if (series.correlation_factor > 1.0) {
    series.warnings.add(
        WarningKind::series,
        fmt::format("residuals are correlated from frame to frame; standard errors are {:.2g} times those of "
                    "independent frames",
                    series.correlation_factor));
  }
  // The errors of the fit within are others.
  constexpr double kTolerable = 0.1;
  for (const SeriesCoefficient& c : series.coefficients) {
    if (c.integration_shift.value_or(0.0) <= kTolerable || series.warnings.has(WarningKind::steps)) continue;
    series.warnings.add(
        WarningKind::steps,
        fmt::format("the steps of the integration are too long: with half of them a value of {} "
                    "would move by {:.2g} of its standard errors; a shorter `step` is advised",
                    c.name, *c.integration_shift));
  }
  for (const SeriesCoefficient& c : series.coefficients) {
    const auto nothing = std::ranges::count(c.basis, InstantBasis::nothing);
    if (nothing > 0) {
      series.warnings.add(WarningKind::series,
                          fmt::format("the captures do not determine {} at {} of {} instants", c.name,
                                      nothing, c.values.size()));
    }
  }
}

}  // namespace

std::string to_string(InstantBasis basis) {
  switch (basis) {
    case InstantBasis::frames:
      return "frames";
    case InstantBasis::neighbours:
      return "neighbours";
    case InstantBasis::bound:
      return "bound";
    case InstantBasis::nothing:
      return "nothing";
  }
  return {};
}

void validate(const SeriesOptions& options) {
  if (options.coefficients.empty()) {
    throw ArgumentError(
        "series.coefficients is empty; at least one parameter that changes along the captures was expected");
  }
  for (const std::string& name : options.coefficients) {
    if (std::ranges::count(options.coefficients, name) == 1) continue;
    throw ArgumentError(
        fmt::format("series.coefficients names \"{}\" twice; each coefficient once was expected", name));
  }
  require_positive(options.span, "series.span");
  if (options.stride) require_positive(*options.stride, "series.stride");
  if (options.stride && *options.stride > options.span) {
    throw ArgumentError(
        fmt::format("series.stride is {}, and series.span {}; a stride of at most the span "
                    "was expected",
                    *options.stride, options.span));
  }
  require(options.order == 1 || options.order == 2, "series.order", options.order, "1 or 2");
  for (const auto& [name, scale] : options.scales) {
    require_positive(scale, fmt::format("the smoothness of \"{}\" in series", name));
    if (std::ranges::count(options.coefficients, name) > 0) continue;
    throw ArgumentError(fmt::format("series has a smoothness of \"{}\", which is none of its coefficients{}",
                                    name, suggestion(name, options.coefficients)));
  }
}

CoefficientSeries fit_series(const std::shared_ptr<const models::Model>& model,
                             std::span<const Capture> captures, const FitOptions& options,
                             const SeriesOptions& series) {
  validate(options);
  validate(series);
  check_combination(options, series);
  const models::ModelInfo& info = model->info();
  for (const std::string& name : series.coefficients) check_coefficient(info, options, name);
  const SeriesSpans spans = series_spans(captures, options, series);
  const FitOptions cut_options = options_of_spans(options, spans, series);

  CoefficientSeries result{.model = info.name,
                           .time_unit = models::time_unit(info),
                           .joined = spans.joined,
                           .spans = spans.count,
                           .instants = spans.knots.instants};
  const auto family = constant_family(model, options);
  if (!spans.joined) check_sliding(family->info(), spans, cut_options);
  result.constant = fit(*family, spans.captures, cut_options);
  result.message = fmt::format("with constant coefficients: {}", result.constant.message);
  if (result.constant.status == Termination::failed) return result;

  SeriesFits fits(model, spans, cut_options, series, result.constant);
  Chosen chosen;
  if (fits.has_free_scales()) {
    chosen = fits.estimates_noise() ? choose_with_levels(fits, result.constant, result.trials)
                                    : choose(fits, result.trials);
    result.factor = chosen.factor;
  } else {
    chosen.fit = fits.estimates_noise() ? fits.fit_with_levels(1.0) : fits.fit_with(1.0);
    if (chosen.fit.status != Termination::failed) chosen.judgement = fits.judge(chosen.fit, 1.0);
  }
  result.fit = std::move(chosen.fit);
  result.status = result.fit.status;
  result.message = result.fit.message;
  if (result.status == Termination::failed) return result;
  result.effective = chosen.judgement.effective;
  result.correlation_factor = growth_of_errors(result.fit);
  for (std::size_t c = 0; c < series.coefficients.size(); ++c) {
    result.coefficients.push_back(
        fits.describe(result.fit, c, chosen.factor, chosen.judgement, result.correlation_factor));
  }
  add_series_warnings(options, result);
  add_replay(info, result.fit, spans.knots, options, result);
  return result;
}

}  // namespace samara::identification
