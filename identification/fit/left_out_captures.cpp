#include "samara/identification/fit/left_out_captures.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/parallel.h"
#include "samara/base/units.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/problem/segments.h"
#include "samara/identification/solve/held_noise.h"

namespace samara::identification {

namespace {

/// The options of the fit, with the coefficients held.
FitOptions holding(const models::FamilyInfo& family, const FitResult& fitted, FitOptions options,
                   const PredictionOptions& prediction) {
  for (const Coefficient& c : fitted.coefficients) {
    if (std::ranges::count(options.unknowns.per_capture, c.name) > 0) continue;
    options.unknowns.fixed[c.name] = c.value;
    std::erase(options.unknowns.shared, c.name);
    std::erase(options.unknowns.log_scale, c.name);
    options.unknowns.box.erase(c.name);
    options.priors.coordinates.erase(c.name);
    options.starts.initial.erase(c.name);
  }
  // What was fitted is compared, whatever the captures left out measure besides. What was read from a file
  // does not say it.
  if (const CaptureFit* const one = fitted.captures.empty() ? nullptr : &fitted.captures.front();
      one != nullptr && one->frames > 0) {
    const auto count = static_cast<std::size_t>(one->measured.cols());
    options.compared.outputs.clear();
    for (std::size_t o = 0; o < count; ++o) options.compared.outputs.push_back(fitted.residuals[o].output);
    if (fitted.residuals.size() > count)
      options.compared.outputs.insert(options.compared.outputs.end(), family.attitude.begin(),
                                      family.attitude.end());
  }
  for (const std::string& name : prediction.hidden) {
    options.unknowns.known.erase(name);
    const auto c = std::ranges::find(family.coordinates, name, &models::FamilyCoordinate::name);
    if (c != family.coordinates.end() && !c->is_initial) options.unknowns.per_capture.push_back(name);
  }
  options.priors.combinations.clear();
  hold_noise(fitted, options);
  options.compared.span = prediction.span;
  options.compared.stride.reset();
  options.uncertainty = {};
  options.starts.global = {};
  options.progress = {};
  return options;
}

/// What the spans are fitted to, and what else captures measure of what the model says: velocities, angles
/// and attitudes, but no place of which the fit knows no start.
PredictedOutputs predicted_outputs(const models::FamilyInfo& family, std::span<const Capture> left_out,
                                   const FitOptions& held) {
  PredictedOutputs predicted;
  const FitProblem problem = describe_problem(family, left_out, held);
  for (const ComparedOutput& output : problem.outputs)
    predicted.outputs.push_back({output.name, output.unit});
  const auto is_measured = [&](const models::FamilyOutput& output) {
    return std::ranges::any_of(left_out, [&](const Capture& capture) {
      return capture.has(output.name) && same_dimension(capture.channel(output.name).unit, output.unit);
    });
  };
  for (const models::FamilyOutput& output : family.outputs) {
    const bool is_part = std::ranges::count(family.attitude, output.name) > 0 ||
                         std::ranges::count(family.translations, output.name) > 0 ||
                         std::ranges::count(predicted.outputs, output.name, &models::FamilyOutput::name) > 0;
    if (!is_part && is_measured(output)) predicted.outputs.push_back(output);
  }
  const bool has_attitude = std::ranges::any_of(left_out, [&](const Capture& capture) {
    return std::ranges::all_of(family.attitude, [&](const std::string& part) { return capture.has(part); });
  });
  if (!family.attitude.empty() && has_attitude) predicted.attitude = family.attitude;
  return predicted;
}

/// Captures, or spans of each with what follows them.
std::vector<Capture> cut(std::span<const Capture> left_out, const PredictedOutputs& predicted,
                         const PredictionOptions& prediction) {
  if (!prediction.stride) return {left_out.begin(), left_out.end()};
  std::vector<std::string> places;
  for (const models::FamilyOutput& output : predicted.outputs) {
    if (output.unit == "m") places.push_back(output.name);
  }
  std::vector<Capture> parts;
  for (const Capture& capture : left_out) {
    for (Capture& part : spans(capture, prediction.span + prediction.ahead, *prediction.stride, places))
      parts.push_back(std::move(part));
  }
  return parts;
}

/// A reason once, however many captures it holds for.
std::string lack_sentence(const std::string& reason, const std::vector<std::string>& captures) {
  std::string sentence = fmt::format("capture \"{}\" was not predicted: {}", captures.front(), reason);
  if (captures.size() == 1) return sentence;
  return fmt::format("{}; nor, for the same reason, {} \"{}\"", sentence,
                     captures.size() > 2 ? "were" : "was",
                     fmt::join(captures.begin() + 1, captures.end(), "\", \""));
}

/// By the fit's labels; where a capture left out lacks one, each motion by itself.
std::vector<int> clusters_left_out(std::span<const Capture> left_out,
                                   const std::vector<std::string>& cluster_by) {
  const bool has_labels = std::ranges::all_of(left_out, [&](const Capture& capture) {
    return std::ranges::all_of(cluster_by, [&](const std::string& l) { return capture.labels.contains(l); });
  });
  return clusters_of(left_out, has_labels ? cluster_by : std::vector<std::string>{});
}

/// What the captures left out can show.
/// @param clusters of each
void add_capture_predictions(const models::TrajectoryFamily& family, std::span<const Capture> left_out,
                             const std::vector<int>& clusters, const PredictedOutputs& predicted,
                             const FitOptions& held, const PredictionOptions& prediction,
                             PredictedCaptures& outcome) {
  std::vector<CapturePrediction> all(left_out.size());
  parallel_for(left_out.size(), [&](std::size_t k) {
    all[k] = predict_capture(family, left_out[k], predicted, held, prediction);
  });
  std::vector<CapturePrediction>& predictions = outcome.predictions;
  std::vector<std::string>& sentences = outcome.sentences;
  int failures = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const std::string& id = left_out[k].id;
    all[k].cluster = clusters[k];
    if (!all[k].lack.empty()) {
      outcome.add_lack(all[k].lack, {id});
      continue;
    }
    if (!all[k].failure.empty()) {
      ++failures;
      sentences.push_back(fmt::format(
          "capture \"{}\" counts for the baselines only, since the model failed: {}", id, all[k].failure));
    }
    predictions.push_back(std::move(all[k]));
  }
  if (failures > 0) {
    sentences.push_back(
        fmt::format("the model failed on {} of {} captures left out", failures, predictions.size()));
  }
  if (predictions.empty()) {
    if (!left_out.empty()) sentences.emplace_back("none of the captures left out could be predicted");
  } else if (std::string sentence = shortfall(predictions, family.info().source, prediction);
             !sentence.empty()) {
    sentences.push_back(std::move(sentence));
  }
}

/// Spans all along captures, each with what follows it: four for each that is predicted, or each span's length; fewer
/// where that were very many.
std::vector<Capture> cut_along(std::span<const Capture> captures, const PredictedOutputs& predicted,
                               const PredictionOptions& prediction) {
  constexpr double kDenser = 4.0, kMost = 120.0;
  double all = 0.0;  // s
  for (const Capture& capture : captures) {
    if (capture.times.size() > 0) all += capture.times[capture.times.size() - 1] - capture.times[0];
  }
  PredictionOptions along = prediction;
  along.stride = std::max(prediction.stride.value_or(prediction.span) / kDenser, all / kMost);
  return cut(captures, predicted, along);
}

const Channel& channel_of_view(const Capture& capture, const std::string& name) {
  try {
    return capture.channel(name);
  } catch (const ArgumentError& error) {
    throw ArgumentError(fmt::format("prediction.views: {}", error.what()));
  }
}

}  // namespace

void PredictedCaptures::add_lack(const std::string& reason, const std::vector<std::string>& captures) {
  const auto place = std::ranges::find(lacks, reason, [](const auto& lack) { return lack.first; });
  std::vector<std::string>& named =
      place == lacks.end() ? lacks.emplace_back(reason, std::vector<std::string>{}).second : place->second;
  named.insert(named.end(), captures.begin(), captures.end());
}

void PredictedCaptures::add_sentences(const std::vector<std::string>& others) {
  for (const std::string& sentence : others) {
    if (std::ranges::count(sentences, sentence) == 0) sentences.push_back(sentence);
  }
}

void PredictedCaptures::add(PredictedCaptures other) {
  if (!other.compared.empty()) compared = std::move(other.compared);
  int first = 0;
  for (const CapturePrediction& one : predictions) first = std::max(first, one.cluster + 1);
  for (const CapturePrediction& one : along) first = std::max(first, one.cluster + 1);
  for (auto* const all : {&other.predictions, &other.along}) {
    for (CapturePrediction& one : *all) {
      one.cluster += first;
      (all == &other.along ? along : predictions).push_back(std::move(one));
    }
  }
  for (const auto& [reason, captures] : other.lacks) add_lack(reason, captures);
  add_sentences(other.sentences);
  for (std::string& sentence : other.shares) shares.push_back(std::move(sentence));
}

void check_prediction(const models::FamilyInfo& family, const FitOptions& options,
                      const PredictionOptions& prediction) {
  for (const auto& [name, value] : {std::pair{"span", prediction.span},
                                    {"ahead", prediction.ahead},
                                    {"stride", prediction.stride.value_or(1.0)}}) {
    if (value > 0.0 && std::isfinite(value)) continue;
    throw ArgumentError(
        fmt::format("{} of a prediction is {}; a positive number of seconds was expected", name, value));
  }
  if (prediction.stride && options.measurement.delay) {
    throw ArgumentError(
        "stride: a span that is predicted starts where it is cut, not at a release, and has no delay; "
        "predictions from the first frame were expected");
  }
  if (prediction.stride && !family.autonomous) {
    throw ArgumentError(
        fmt::format("stride: the equations of \"{}\" depend on time, and spans that are predicted have times "
                    "of their own; predictions from the first frame were expected",
                    family.model));
  }
  for (const std::string& name : prediction.hidden) {
    if (options.unknowns.known.contains(name)) continue;
    throw ArgumentError(fmt::format(
        "a prediction hides \"{}\", which is not known of each capture; a name in `known` was expected",
        name));
  }
}

void check_views(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                 const FitOptions& options, const PredictionOptions& prediction) {
  if (prediction.views.empty() || captures.empty()) return;
  for (const Capture& capture : captures) {
    for (const auto& [first, second] : prediction.views) {
      const std::string &unit = channel_of_view(capture, first).unit,
                        &other = channel_of_view(capture, second).unit;
      if (unit == other) continue;
      throw ArgumentError(
          fmt::format("prediction.views: of capture \"{}\" \"{}\" is in {} and \"{}\" in {}; a pair of one "
                      "unit, which a quarter turn exchanges, was expected",
                      capture.id, first, unit, second, other));
    }
  }
  const std::vector<Quantity> compared =
      quantities(family, predicted_outputs(family.info(), captures, options), options);
  const bool is_in_space = std::ranges::any_of(
      compared, [](const Quantity& quantity) { return quantity.components.level.size() == 2; });
  if (!is_in_space)
    throw ArgumentError(
        "prediction.views: views are exchanged by a quarter turn about the vertical, and the motion has no "
        "two level components; lengths x, y and z, and no other, were expected to be predicted");
}

namespace {

/// In a sentence each, captures whose table has the name of one that was fitted, and other contents.
std::vector<std::string> changed_tables(const FitResult& fitted, std::span<const Capture> left_out) {
  std::vector<std::string> sentences;
  for (const Capture& capture : left_out) {
    const auto is_namesake = [&](const CaptureFit& c) {
      return c.whole == capture.whole() && !c.checksum.empty() && is_same_file(capture.file, c.file);
    };
    if (capture.checksum.empty() || std::ranges::none_of(fitted.captures, is_namesake)) continue;
    sentences.push_back(fmt::format(
        "\"{}\" has the name of a table that was fitted, and other contents: if capture \"{}\" is of "
        "the same motion, its predictions look too good",
        capture.file, capture.whole()));
  }
  return sentences;
}

}  // namespace

void refuse_fitted(const std::string& whole, const std::string& file, const std::string& checksum,
                   std::span<const Capture> left_out) {
  for (const Capture& capture : left_out) {
    if (capture.whole() != whole || capture.file.empty()) continue;
    const bool is_known = !checksum.empty() && !capture.checksum.empty();
    if (is_known ? capture.checksum != checksum : !is_same_file(capture.file, file)) continue;
    throw InputError(capture.file, fmt::format("capture \"{}\" is fitted as well as left out; captures that "
                                               "the fit does not see were expected",
                                               whole));
  }
}

PredictedCaptures look_ahead(const models::TrajectoryFamily& family, const FitResult& fitted,
                             std::span<const Capture> left_out, const FitOptions& options,
                             const PredictionOptions& prediction, bool wants_along) {
  check_prediction(family.info(), options, prediction);
  refuse_repeated(left_out, "left out");
  if (fitted.status == Termination::failed || left_out.empty()) return {};
  for (const CaptureFit& c : fitted.captures) refuse_fitted(c.whole, c.file, c.checksum, left_out);
  const FitOptions held = holding(family.info(), fitted, options, prediction);
  check_views(family, left_out, held, prediction);
  const PredictedOutputs predicted = predicted_outputs(family.info(), left_out, held);
  std::vector<Capture> parts = cut(left_out, predicted, prediction);
  const std::size_t count = parts.size();
  // A span begins where it is cut, not at a release: it has no delay.
  if (wants_along && !options.measurement.delay) {
    for (Capture& part : cut_along(left_out, predicted, prediction)) parts.push_back(std::move(part));
  }
  const std::vector<int> clusters = clusters_left_out(parts, options.uncertainty.cluster_by);
  PredictedCaptures outcome{.compared = quantities(family, predicted, held)};
  outcome.add_sentences(changed_tables(fitted, left_out));
  add_capture_predictions(family, std::span(parts).first(count), clusters, predicted, held, prediction,
                          outcome);
  outcome.along.resize(parts.size() - count);
  parallel_for(outcome.along.size(), [&](std::size_t k) {
    outcome.along[k] = predict_capture(family, parts[count + k], predicted, held, prediction, false);
    outcome.along[k].cluster = clusters[count + k];
  });
  std::erase_if(outcome.along, [](const CapturePrediction& one) { return !one.lack.empty(); });
  return outcome;
}

std::string shortfall(const std::vector<CapturePrediction>& predictions, const std::string& source,
                      const PredictionOptions& prediction) {
  const double reach = reach_of(predictions, prediction);
  if (!(reach < prediction.ahead)) return {};
  const bool is_cut = std::ranges::any_of(predictions, &CapturePrediction::is_cut);
  return fmt::format(
      "predictions go to {:.4g} s ahead, not to {:.4g} s: {}", reach, prediction.ahead,
      is_cut ? fmt::format("the {} ends there", source) : "there is no frame to compare beyond");
}

void add_sentences(PredictedCaptures& outcome, Warnings& warnings) {
  for (const auto& [reason, captures] : outcome.lacks)
    warnings.add(WarningKind::predictions, lack_sentence(reason, captures));
  warnings.add_all(WarningKind::predictions, std::move(outcome.sentences));
  warnings.add_all(WarningKind::predictions, std::move(outcome.shares));
}

}  // namespace samara::identification
