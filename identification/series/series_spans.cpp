#include "samara/identification/series/series_spans.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/problem/fit_problem.h"

namespace samara::identification {

namespace {

constexpr Eigen::Index kFewestFrames = 3;
/// Unknowns of a series: their matrix is dense.
constexpr double kMostValues = 1000.0;
/// Of a spacing: rounding of times must not make or break a span.
constexpr double kRounding = 1e-6;

struct Range {
  double begin = 0.0, end = 0.0;
};

Range range_of(std::span<const Capture> captures) {
  Range range{INFINITY, -INFINITY};
  for (const Capture& capture : captures) {
    if (capture.times.size() == 0 || !capture.times.allFinite()) continue;  // refused where it is fitted
    range.begin = std::min(range.begin, capture.times.minCoeff());
    range.end = std::max(range.end, capture.times.maxCoeff());
  }
  return range;
}

/// The frames of a capture in a span, both ends included.
std::optional<Capture> part(const Capture& capture, double begin, double end, double rounding) {
  std::vector<Eigen::Index> frames;
  for (Eigen::Index k = 0; k < capture.times.size(); ++k) {
    if (capture.times[k] >= begin - rounding && capture.times[k] <= end + rounding) frames.push_back(k);
  }
  if (static_cast<Eigen::Index>(frames.size()) < kFewestFrames) return {};
  Capture span = capture;
  span.id = span_id(capture.id, begin);
  span.labels["span"] = fmt::format("{:.9g}", begin);
  span.times = Eigen::VectorXd(capture.times(frames));
  for (std::size_t c = 0; c < span.channels.size(); ++c) {
    if (capture.channels[c].values.size() == capture.times.size())
      span.channels[c].values = Eigen::VectorXd(capture.channels[c].values(frames));
  }
  return span;
}

/// The centres of the spans, and the first and the last frame.
Eigen::VectorXd instants_of(const std::vector<double>& centres, const Range& range) {
  Eigen::VectorXd instants(static_cast<Eigen::Index>(centres.size()) + 2);
  instants[0] = range.begin;
  for (std::size_t k = 0; k < centres.size(); ++k) instants[static_cast<Eigen::Index>(k) + 1] = centres[k];
  instants[instants.size() - 1] = range.end;
  return instants;
}

void check_length(std::span<const Capture> captures, const Range& range, const SeriesOptions& series) {
  const double duration = range.end - range.begin;
  if (!(duration > 0.0)) {
    throw ArgumentError(
        fmt::format("capture \"{}\" does not last for any time; frames at several times were "
                    "expected for a series",
                    captures.front().id));
  }
  if (2.0 * series.span > duration * (1.0 + kRounding)) {
    throw ArgumentError(
        fmt::format("series.span is {} s, but {} {} s; a span of at most half of that was "
                    "expected",
                    series.span,
                    captures.size() == 1 ? fmt::format("capture \"{}\" lasts", captures.front().id)
                                         : fmt::format("the {} captures last", captures.size()),
                    duration));
  }
  const double values =
      duration / series.stride.value_or(series.span) * static_cast<double>(series.coefficients.size());
  if (values > kMostValues) {
    throw ArgumentError(
        fmt::format("series would have {:.0f} values over {} s; at most {:.0f} were expected, "
                    "from longer spans or strides",
                    values, duration, kMostValues));
  }
}

}  // namespace

void check_sliding(const models::FamilyInfo& family, const SeriesSpans& spans, const FitOptions& options) {
  const FitProblem problem = make_problem(family, spans.captures, options);
  std::vector<std::string> outputs;
  for (const models::FamilyOutput& output : family.outputs) outputs.push_back(output.name);
  for (const std::string& state : family.states.empty() ? outputs : family.states) {
    if (position(problem.own, state + "(0)")) continue;
    const auto compared = std::ranges::find(problem.outputs, state, &ComparedOutput::name);
    const bool moves = contains(family.translations, state);
    if (moves && (compared == problem.outputs.end() || compared->offset)) continue;
    throw ArgumentError(fmt::format(
        "series.stride: each span starts with a state of its own, but \"{0}(0)\" is not free in each; a "
        "box for it{1}, was expected",
        state, moves ? fmt::format(", or \"{}\" among the offsets", state) : ", not shared, fixed or known"));
  }
  for (const models::FamilyCoordinate& own : problem.own) {
    if (own.is_initial) continue;
    throw ArgumentError(fmt::format(
        "series.stride: \"{}\" of each capture would be of each span; no per_capture was expected",
        own.name));
  }
  if (problem.camera) {
    throw ArgumentError(
        "series.stride: the camera of a capture would be another one in each span; no camera was expected");
  }
  for (const PriorTerm& prior : problem.own_priors) {
    throw ArgumentError(fmt::format(
        "series.stride: the prior of \"{}\" is of where a capture starts, not of each span; no prior "
        "was expected",
        problem.own[static_cast<std::size_t>(prior.weights().front().unknown)].name));
  }
}

SeriesSpans series_spans(std::span<const Capture> captures, const FitOptions& options,
                         const SeriesOptions& series) {
  if (captures.empty()) throw ArgumentError("there are no captures; at least one was expected");
  std::vector<Capture> seen;
  for (const Capture& capture : captures)
    seen.push_back(options.compared.span ? first(capture, *options.compared.span) : capture);
  const Range range = range_of(seen);
  check_length(seen, range, series);
  const double duration = range.end - range.begin;

  SeriesSpans spans{.captures = {}, .knots = {.instants = {}, .coefficients = series.coefficients}};
  std::vector<double> centres;
  spans.joined = !series.stride;
  if (spans.joined) {
    spans.count = static_cast<int>(std::round(duration / series.span));
    spans.spacing = duration / spans.count;
    for (int k = 0; k < spans.count; ++k) centres.push_back(range.begin + (k + 0.5) * spans.spacing);
    spans.captures = std::move(seen);
  } else {
    const double strides = std::ceil((duration - series.span) / *series.stride - kRounding);
    spans.spacing = (duration - series.span) / strides;
    spans.count = 1 + static_cast<int>(strides);
    double frames = 0.0, distinct = 0.0;
    for (const Capture& capture : seen) distinct += static_cast<double>(capture.times.size());
    for (int k = 0; k < spans.count; ++k) {
      const double begin = range.begin + k * spans.spacing;
      centres.push_back(begin + 0.5 * series.span);
      for (const Capture& capture : seen) {
        auto span = part(capture, begin, begin + series.span, kRounding * spans.spacing);
        if (!span) continue;
        frames += static_cast<double>(span->times.size());
        spans.captures.push_back(std::move(*span));
      }
    }
    if (spans.captures.empty()) {
      throw ArgumentError(
          fmt::format("no span of {} s holds {} frames or more; a longer series.span was "
                      "expected",
                      series.span, kFewestFrames));
    }
    spans.overlap = std::max(1.0, frames / distinct);
  }
  spans.knots.instants = instants_of(centres, range);
  return spans;
}

}  // namespace samara::identification
