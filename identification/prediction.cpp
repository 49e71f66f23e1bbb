#include "samara/identification/prediction.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/fit.h"
#include "samara/identification/fit_problem.h"
#include "samara/identification/fitted_motion.h"
#include "samara/identification/held_noise.h"
#include "samara/identification/medians.h"
#include "samara/identification/segments.h"
#include "samara/identification/smoothing.h"

namespace samara::identification {

namespace {

/// A frame counts as the last one ahead if it lies within this part of the way from its end.
constexpr double kAtEnd = 0.1;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void check(const PredictionOptions& prediction) {
  for (const auto& [name, value] : {std::pair{"window", prediction.window}, {"ahead", prediction.ahead}}) {
    if (value > 0.0 && std::isfinite(value)) continue;
    throw ArgumentError(
        fmt::format("{} of a prediction is {}; a positive number of seconds was expected", name, value));
  }
}

/// Outputs with values frame by frame; an attitude as a whole stands behind them in the residuals.
std::vector<OutputRms> compared_outputs(const FitResult& fitted) {
  const auto count = static_cast<std::ptrdiff_t>(fitted.captures.front().measured.cols());
  return {fitted.residuals.begin(), fitted.residuals.begin() + count};
}

bool compares_attitude(const FitResult& fitted) {
  return fitted.residuals.size() > compared_outputs(fitted).size();
}

/// The options of the fit, with the coefficients held.
FitOptions holding(const FamilyInfo& family, const FitResult& fitted, FitOptions options,
                   const PredictionOptions& prediction) {
  for (const Coefficient& c : fitted.coefficients) {
    options.fixed[c.name] = c.value;
    std::erase(options.shared, c.name);
    std::erase(options.log_scale, c.name);
    options.box.erase(c.name);
    options.priors.erase(c.name);
    options.initial.erase(c.name);
  }
  options.outputs.clear();
  for (const OutputRms& output : compared_outputs(fitted)) options.outputs.push_back(output.output);
  if (compares_attitude(fitted)) {
    options.outputs.insert(options.outputs.end(), family.attitude.begin(), family.attitude.end());
  }
  if (fitted.captures.front().nuisances.empty()) options.segments.length.reset();
  hold_noise(fitted, options);
  options.window = prediction.window;
  options.cluster_by.clear();
  options.profiles = false;
  options.progress = {};
  return options;
}

/// Frames of the capture by their time since its first; a frame on a border belongs to what lies before it.
std::vector<Eigen::Index> frames_between(const Capture& capture, double after, double until) {
  std::vector<Eigen::Index> frames;
  for (Eigen::Index k = frames_within(capture, after); k < frames_within(capture, until); ++k) {
    frames.push_back(k);
  }
  return frames;
}

Eigen::MatrixXd measured(const Capture& capture, const std::vector<std::string>& outputs,
                         const std::vector<Eigen::Index>& frames) {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(frames.size()), static_cast<Eigen::Index>(outputs.size()));
  for (std::size_t o = 0; o < outputs.size(); ++o)
    values.col(static_cast<Eigen::Index>(o)) = capture.channel(outputs[o]).values(frames);
  return values;
}

/// Outputs that are compared as one: all lengths, or a single other one.
struct Quantity {
  std::string name, unit;
  double period = 0.0;  ///< 0: on the line
  std::vector<int> columns;
};

std::vector<Quantity> quantities(const std::vector<OutputRms>& outputs, const FitOptions& options) {
  std::vector<Quantity> result;
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const bool is_length = outputs[o].unit == "m";
    const auto position = std::ranges::find(result, std::string("position"), &Quantity::name);
    if (is_length && position != result.end()) {
      position->columns.push_back(static_cast<int>(o));
    } else {
      const double period = period_of({outputs[o].output, outputs[o].unit}, options);
      result.push_back(
          {is_length ? "position" : outputs[o].output, outputs[o].unit, period, {static_cast<int>(o)}});
    }
  }
  return result;
}

/// One capture: what was seen, what followed, and what the model made of it.
struct Outlook {
  SeenMotion seen = {};
  Eigen::VectorXd times = {};  ///< since the first frame
  Eigen::MatrixXd truth = {};
  Eigen::MatrixXd model = {};  ///< NaN where it failed
  std::string lack = {};       ///< why nothing can be compared; empty: it can
  std::string failure = {};    ///< why the model says nothing; empty: it does
};

/// Whether the window holds more values than unknowns.
/// @param attitudes frames x 4, or none
bool can_be_fitted(const Eigen::MatrixXd& positions, const Eigen::MatrixXd& attitudes, std::size_t unknowns) {
  const auto is_seen = [](const auto& value) { return value == value; };  // not NaN
  auto values = static_cast<std::size_t>(positions.unaryExpr(is_seen).count());
  // An attitude counts as three.
  if (attitudes.cols() > 0) {
    values += 3 * static_cast<std::size_t>(attitudes.unaryExpr(is_seen).rowwise().all().count());
  }
  return positions.rows() >= 3 && values > unknowns;
}

/// What a fit of the capture would give where nothing is its own.
FitResult without_unknowns(FitResult fitted, const Capture& capture, const FitOptions& options) {
  CaptureFit one{.id = capture.id, .labels = capture.labels};
  if (options.averaged_frames > 1) {
    one.interval = median_interval(first(capture, *options.window).times);
    one.start = -0.5 * (options.averaged_frames - 1) * one.interval;
  }
  fitted.captures = {one};
  return fitted;
}

/// @param names of the outputs that are compared
Outlook outlook_of(const TrajectoryFamily& family, const FitResult& fitted, const Capture& capture,
                   const std::vector<std::string>& names, const FitOptions& options,
                   const PredictionOptions& prediction) {
  if (capture.times.size() == 0) return {.lack = "it has no frames"};
  const std::vector<Eigen::Index> before = frames_between(capture, -1.0, prediction.window);
  const double end =
      std::min(prediction.window + prediction.ahead, family.info().end_time - capture.times[0]);
  const std::vector<Eigen::Index> after = frames_between(capture, prediction.window, end);
  const Eigen::VectorXd since = capture.times.array() - capture.times[0];
  Outlook outlook;
  outlook.seen = {since(before), measured(capture, names, before)};
  outlook.times = since(after);
  outlook.truth = measured(capture, names, after);
  const auto attitude = compares_attitude(fitted) ? family.info().attitude : std::vector<std::string>{};
  const Eigen::MatrixXd attitudes = measured(capture, attitude, before);
  const std::size_t unknowns = fitted.captures.front().nuisances.size();
  if (!can_be_fitted(outlook.seen.positions, attitudes, unknowns)) {
    outlook.lack = fmt::format("its first {} s, {} frames, hold too little to fit its {} unknowns",
                               prediction.window, before.size(), unknowns);
  } else if (after.empty()) {
    outlook.lack = fmt::format("it has no frame between {} s and {} s", prediction.window, end);
  }
  if (!outlook.lack.empty()) return outlook;

  // Without unknowns of its own there is nothing to fit.
  const FitResult window = unknowns > 0 ? fit(family, std::span(&capture, 1), options)
                                        : without_unknowns(fitted, capture, options);
  outlook.model = Eigen::MatrixXd::Constant(outlook.truth.rows(), outlook.truth.cols(), kNaN);
  if (window.status == FitStatus::failed) {
    outlook.failure = window.message;
    return outlook;
  }
  const Eigen::VectorXd times = capture.times(after).cwiseMin(family.info().end_time);
  const std::optional<Eigen::MatrixXd> model =
      fitted_motion(family, options, window, 0, {times.begin(), times.end()}, names);
  if (model) {
    outlook.model = *model;
  } else {
    outlook.failure = "there is no trajectory beyond the window";
  }
  return outlook;
}

/// Tallies of one predictor, one pair per quantity.
struct Predictor {
  std::optional<Baseline> baseline = {};  ///< empty: the model
  std::vector<PredictionTally> all = {}, last = {};

  std::string name() const { return baseline ? to_string(*baseline) : "model"; }

  Eigen::MatrixXd predicted(const Outlook& outlook) const {
    return baseline ? predict(*baseline, outlook.seen, outlook.times) : outlook.model;
  }
};

/// The last frame, if it lies near the end of the way; else nothing to compare.
Eigen::MatrixXd last_row(const Eigen::MatrixXd& rows, const Outlook& outlook,
                         const PredictionOptions& prediction) {
  const double end = prediction.window + prediction.ahead;
  const bool at_end = outlook.times[outlook.times.size() - 1] >= end - kAtEnd * prediction.ahead;
  return rows.bottomRows(at_end ? 1 : 0);
}

/// What repeats goes on where it was seen to jump: baselines are polynomials.
void unwrap(const std::vector<Quantity>& compared, SeenMotion& seen) {
  for (const Quantity& q : compared) {
    if (q.period == 0.0) continue;
    for (const int column : q.columns)
      seen.positions.col(column) = unwrapped(seen.times, seen.positions.col(column), q.period);
  }
}

/// The same points of a circle of length `period`, where they are nearest to others.
Eigen::MatrixXd nearest(const Eigen::MatrixXd& points, const Eigen::MatrixXd& others, double period) {
  if (period == 0.0) return points;
  return others + (points - others).unaryExpr([&](double d) { return std::remainder(d, period); });
}

void tally(const Outlook& outlook, const std::vector<Quantity>& compared, const PredictionOptions& prediction,
           Predictor& predictor) {
  const Eigen::MatrixXd predicted = predictor.predicted(outlook);
  for (std::size_t k = 0; k < compared.size(); ++k) {
    const Eigen::MatrixXd guess = predicted(Eigen::all, compared[k].columns);
    const Eigen::MatrixXd truth =
        nearest(outlook.truth(Eigen::all, compared[k].columns), guess, compared[k].period);
    predictor.all[k].add(prediction_distances(guess, truth));
    predictor.last[k].add(
        prediction_distances(last_row(guess, outlook, prediction), last_row(truth, outlook, prediction)));
  }
}

/// s beyond the window, of the last frame of all.
double reach_of(const std::vector<Outlook>& outlooks, const PredictionOptions& prediction) {
  double reach = 0.0;
  for (const Outlook& outlook : outlooks)
    reach = std::max(reach, outlook.times[outlook.times.size() - 1] - prediction.window);
  return reach >= (1.0 - kAtEnd) * prediction.ahead ? prediction.ahead : reach;
}

/// @param reach s, to which there are frames
std::vector<Predictor> predictors(const std::vector<Quantity>& compared, const PredictionOptions& prediction,
                                  double reach) {
  std::vector<Predictor> all(1);
  for (const Baseline baseline : all_baselines()) all.push_back({.baseline = baseline});
  for (Predictor& p : all) {
    for (const Quantity& q : compared) {
      p.all.emplace_back(p.name(), fmt::format("{}, up to {:.4g} s ahead", q.name, reach), q.unit);
      p.last.emplace_back(p.name(), fmt::format("{}, {:.4g} s ahead", q.name, prediction.ahead), q.unit);
    }
  }
  return all;
}

/// Whether two names are those of one file.
bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code missing;
  return a == b || std::filesystem::equivalent(a, b, missing);
}

/// @param id, file of a capture that is fitted
void refuse_fitted(const std::string& id, const std::string& file, std::span<const Capture> left_out) {
  for (const Capture& capture : left_out) {
    if (capture.id != id || capture.file.empty() || !is_same_file(capture.file, file)) continue;
    throw InputError(capture.file, fmt::format("capture \"{}\" is fitted as well as left out; captures that "
                                               "the fit does not see were expected",
                                               id));
  }
}

/// What the captures left out can show, with sentences about those that can show nothing.
std::vector<Outlook> outlooks_of(const TrajectoryFamily& family, const FitResult& fitted,
                                 std::span<const Capture> left_out, const FitOptions& options,
                                 const PredictionOptions& prediction, std::vector<std::string>& sentences) {
  std::vector<std::string> names;
  for (const OutputRms& output : compared_outputs(fitted)) names.push_back(output.output);
  std::vector<Outlook> outlooks;
  int failures = 0;
  for (const Capture& capture : left_out) {
    Outlook outlook = outlook_of(family, fitted, capture, names, options, prediction);
    if (!outlook.lack.empty()) {
      sentences.push_back(fmt::format("capture \"{}\" was not predicted: {}", capture.id, outlook.lack));
      continue;
    }
    if (!outlook.failure.empty()) {
      ++failures;
      sentences.push_back(
          fmt::format("capture \"{}\" counts for the baselines only, since the model failed: {}", capture.id,
                      outlook.failure));
    }
    outlooks.push_back(std::move(outlook));
  }
  if (failures > 0) {
    sentences.push_back(
        fmt::format("the model failed on {} of {} captures left out", failures, outlooks.size()));
  }
  if (outlooks.empty()) {
    if (!left_out.empty()) sentences.emplace_back("none of the captures left out could be predicted");
  } else if (const double reach = reach_of(outlooks, prediction); reach < prediction.ahead) {
    sentences.push_back(
        fmt::format("predictions go to {:.4g} s ahead, not to {:.4g} s: there is no frame to compare beyond",
                    reach, prediction.ahead));
  }
  return outlooks;
}

/// @param sentences what the reader of the scores must know
std::vector<PredictionScore> scores_of(const TrajectoryFamily& family, const FitResult& fitted,
                                       std::span<const Capture> left_out, const FitOptions& options,
                                       const PredictionOptions& prediction,
                                       std::vector<std::string>& sentences) {
  check(prediction);
  if (fitted.captures.empty()) return {};
  for (const CaptureFit& c : fitted.captures) refuse_fitted(c.id, c.file, left_out);
  const FitOptions held = holding(family.info(), fitted, options, prediction);
  const std::vector<Quantity> compared = quantities(compared_outputs(fitted), options);
  std::vector<Outlook> outlooks = outlooks_of(family, fitted, left_out, held, prediction, sentences);
  std::vector<Predictor> all = predictors(compared, prediction, reach_of(outlooks, prediction));
  for (Outlook& outlook : outlooks) {
    unwrap(compared, outlook.seen);
    for (Predictor& predictor : all) tally(outlook, compared, prediction, predictor);
  }
  std::vector<PredictionScore> scores;
  for (std::size_t k = 0; k < compared.size(); ++k) {
    for (const auto which : {&Predictor::last, &Predictor::all}) {
      const bool any = std::ranges::any_of(
          all, [&](const Predictor& predictor) { return (predictor.*which)[k].score().count > 0; });
      for (const Predictor& predictor : all) {
        if (any) scores.push_back((predictor.*which)[k].score());
      }
    }
  }
  return scores;
}

}  // namespace

void check_left_out(const TrajectoryFamily& family, std::span<const Capture> captures,
                    std::span<const Capture> left_out, const FitOptions& options,
                    const PredictionOptions& prediction) {
  check(prediction);
  const FitProblem problem = make_problem(family.info(), captures, options);
  for (const Capture& capture : left_out) check_capture(capture, options, problem);
  for (const Capture& capture : captures) refuse_fitted(capture.id, capture.file, left_out);
}

std::vector<PredictionScore> predict_left_out(const TrajectoryFamily& family, const FitResult& fitted,
                                              std::span<const Capture> left_out, const FitOptions& options,
                                              const PredictionOptions& prediction) {
  std::vector<std::string> unsaid;
  return scores_of(family, fitted, left_out, options, prediction, unsaid);
}

void add_predictions(const TrajectoryFamily& family, std::span<const Capture> left_out,
                     const FitOptions& options, const PredictionOptions& prediction, FitResult& fitted) {
  fitted.predictions = scores_of(family, fitted, left_out, options, prediction, fitted.warnings);
}

}  // namespace samara::identification
