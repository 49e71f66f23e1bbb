#include "samara/identification/fit/capture_prediction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "samara/base/units.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fitted_motion.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/known_values.h"
#include "samara/identification/problem/measurement.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/identification/smoothing/rotation_vectors.h"

namespace samara::identification {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Frames of the capture by their time since its first; a frame on a border belongs to what lies before it.
std::vector<Eigen::Index> frames_between(const Capture& capture, double after, double until) {
  std::vector<Eigen::Index> frames;
  for (Eigen::Index k = frames_within(capture, after); k < frames_within(capture, until); ++k) {
    frames.push_back(k);
  }
  return frames;
}

/// NaN where it does not measure an output.
Eigen::MatrixXd measured(const Capture& capture, const std::vector<std::string>& outputs,
                         const std::vector<Eigen::Index>& frames) {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(frames.size()), static_cast<Eigen::Index>(outputs.size()));
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const auto column = static_cast<Eigen::Index>(o);
    values.col(column).setConstant(kNaN);
    if (capture.has(outputs[o])) values.col(column) = capture.channel(outputs[o]).values(frames);
  }
  return values;
}

/// Frames x pairs.
Eigen::MatrixXcd views_shown(const Capture& capture, const std::vector<ViewPair>& pairs,
                             const std::vector<Eigen::Index>& frames) {
  Eigen::MatrixXcd views(std::ssize(frames), std::ssize(pairs));
  for (Eigen::Index p = 0; p < views.cols(); ++p) {
    const auto& [first, second] = pairs[static_cast<std::size_t>(p)];
    views.col(p).real() = capture.channel(first).values(frames);
    views.col(p).imag() = capture.channel(second).values(frames);
  }
  return views;
}

std::vector<std::string> names_of(const std::vector<models::FamilyOutput>& outputs) {
  std::vector<std::string> names;
  for (const models::FamilyOutput& output : outputs) names.push_back(output.name);
  return names;
}

/// Whether the span holds more values than unknowns.
/// @param attitudes frames x 4, or none
bool can_be_fitted(const Eigen::MatrixXd& positions, const Eigen::MatrixXd& attitudes, int unknowns) {
  const auto is_seen = [](const auto& value) { return value == value; };  // not NaN
  Eigen::Index values = positions.unaryExpr(is_seen).count();
  // An attitude counts as three.
  if (attitudes.cols() > 0) values += 3 * attitudes.unaryExpr(is_seen).rowwise().all().count();
  return positions.rows() >= 3 && values > unknowns;
}

/// The options for one capture, which may lack what others say of themselves.
FitOptions options_for(const models::FamilyInfo& family, const Capture& capture, FitOptions options) {
  for (auto known = options.unknowns.known.begin(); known != options.unknowns.known.end();) {
    if (has_value(capture, known->second)) {
      ++known;
      continue;
    }
    const auto c = std::ranges::find(family.coordinates, known->first, &models::FamilyCoordinate::name);
    if (c != family.coordinates.end() && !c->is_initial) options.unknowns.per_capture.push_back(known->first);
    known = options.unknowns.known.erase(known);
  }
  return options;
}

/// What a fit of the capture would give where nothing is its own.
FitResult without_unknowns(const models::FamilyInfo& family, const Capture& capture,
                           const FitOptions& options) {
  FitResult result{.status = Termination::converged, .fixed = family.fixed};
  for (const auto& [name, value] : options.unknowns.fixed) result.fixed[name] = value;
  CaptureFit one{.id = capture.id, .labels = capture.labels};
  for (const auto& [name, known] : options.unknowns.known)
    one.known[name] = known_value(capture, name, known);
  if (options.compared.averaged_frames > 1) {
    one.interval = median_interval(first(capture, *options.compared.span).times);
    one.start = -0.5 * (options.compared.averaged_frames - 1) * one.interval;
  }
  result.captures = {one};
  return result;
}

/// Of the capture's times, the last at which a frame has a trajectory. That begins at 0, or, with segments,
/// at the first frame of the span with something to compare.
/// @param delay where the delay of the capture's clock may lie, s
/// @param before frames of the span
/// @param attitudes of these, frames x 4, or none
double last_time(const models::FamilyInfo& family, const FitOptions& options, const Capture& capture,
                 const models::Interval& delay, const std::vector<Eigen::Index>& before,
                 const Eigen::MatrixXd& positions, const Eigen::MatrixXd& attitudes) {
  double start = 0.0;
  for (std::size_t k = before.size(); options.segments.length && k-- > 0;) {
    const auto row = static_cast<Eigen::Index>(k);
    const bool has_attitude = attitudes.cols() > 0 && !attitudes.row(row).hasNaN();
    if (has_attitude || !positions.row(row).array().isNaN().all()) start = capture.times[before[k]];
  }
  if (options.segments.length) start -= std::max(0.0, -delay.lower);
  start -= delay.upper;
  // It begins half the width of a mean earlier, and the last mean reaches as far beyond its frame.
  if (options.compared.averaged_frames > 1 && before.size() > 1)
    start -= (options.compared.averaged_frames - 1) * median_interval(capture.times(before));
  return start + family.end_time;
}

/// How fast outputs and the attitude change in each frame, by the equations at the measured state: that of
/// places and angles is kinematics, whatever the coefficients. NaN where the state was not measured.
void add_rates(const models::TrajectoryFamily& family, const Capture& capture,
               const PredictedOutputs& predicted, const std::vector<Eigen::Index>& frames,
               CapturePrediction& result) {
  const models::ParametricModel* equations = family.equations();
  if (equations == nullptr) return;
  const std::vector<models::StateInfo>& states = equations->model().info().states;
  std::vector<std::string> names;
  for (const models::StateInfo& state : states) names.push_back(state.name);
  const Eigen::MatrixXd seen = measured(capture, names, frames);
  const auto place_of = [&](const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  };
  std::vector<double> q;
  for (const models::FamilyCoordinate& c : family.info().coordinates) q.push_back(0.5 * (c.lower + c.upper));
  models::ParametricModel::Workspace workspace = equations->make_workspace();
  std::vector<double> x(names.size()), rates(names.size());
  result.seen.rates = Eigen::MatrixXd::Constant(seen.rows(), std::ssize(predicted.outputs), kNaN);
  if (!predicted.attitude.empty()) result.turn.body_rates = Eigen::MatrixX3d::Constant(seen.rows(), 3, kNaN);
  for (Eigen::Index row = 0; row < seen.rows(); ++row) {
    for (std::size_t s = 0; s < x.size(); ++s) x[s] = seen(row, static_cast<Eigen::Index>(s));
    equations->rhs(0.0, x, q, rates, workspace);
    for (std::size_t o = 0; o < predicted.outputs.size(); ++o) {
      const models::FamilyOutput& output = predicted.outputs[o];
      const std::size_t at = place_of(output.name);
      const bool is_kinematic = output.unit == "m" || output.unit == "rad";
      if (is_kinematic && at < rates.size()) result.seen.rates(row, static_cast<Eigen::Index>(o)) = rates[at];
    }
    if (predicted.attitude.empty() || place_of(predicted.attitude[0]) + 4 > rates.size()) continue;
    const double* const turn = &rates[place_of(predicted.attitude[0])];
    const Attitude now = attitude_of(result.turn.attitudes.row(row).transpose());
    const Attitude product = now.conjugate() * Attitude(turn[0], turn[1], turn[2], turn[3]);
    result.turn.body_rates.row(row) = 2.0 / now.squaredNorm() * product.vec().transpose();
  }
}

/// Where the model goes after the span.
void carry_on(const models::TrajectoryFamily& family, const Capture& capture,
              const PredictedOutputs& predicted, const FitOptions& options, int unknowns,
              const Eigen::VectorXd& times, CapturePrediction& result) {
  const auto outputs = std::ssize(predicted.outputs);
  result.model = Eigen::MatrixXd::Constant(times.size(), outputs, kNaN);
  result.model_attitude = Eigen::MatrixX4d::Constant(times.size(), 4, kNaN);
  const FitResult span = unknowns > 0 ? fit(family, std::span(&capture, 1), options)
                                      : without_unknowns(family.info(), capture, options);
  if (span.status == Termination::failed) {
    result.failure = span.message;
    return;
  }
  std::vector<std::string> names = names_of(predicted.outputs);
  names.insert(names.end(), predicted.attitude.begin(), predicted.attitude.end());
  const std::optional<Eigen::MatrixXd> model =
      fitted_motion(family, options, span, 0, {times.begin(), times.end()}, names);
  if (!model) {
    result.failure = "there is no trajectory beyond the span";
    return;
  }
  result.model = model->leftCols(outputs);
  if (!predicted.attitude.empty()) result.model_attitude = model->rightCols<4>();
}

}  // namespace

CapturePrediction predict_capture(const models::TrajectoryFamily& family, const Capture& capture,
                                  const PredictedOutputs& predicted, const FitOptions& all_options,
                                  const PredictionOptions& prediction, bool asks_model) {
  CapturePrediction result{.file = capture.file, .motion = capture.whole(), .part = capture.id};
  if (capture.times.size() == 0) {
    result.lack = "it has no frames";
    return result;
  }
  // All that a forecast rests on; what follows is looked at to compare.
  Capture known;
  try {
    known = known_at(capture, prediction.span);
  } catch (const std::exception& error) {
    result.lack = fmt::format("its first {} s could not be cleaned alone: {}", prediction.span, error.what());
    return result;
  }
  FitOptions options = options_for(family.info(), known, all_options);
  const FitProblem problem = describe_problem(family.info(), std::span(&known, 1), options);
  const int unknowns = problem.own_count();
  if (unknowns == 0) options.segments.length.reset();  // it starts where its values say, at 0
  const std::vector<std::string> names = names_of(predicted.outputs);
  const std::vector<Eigen::Index> before = frames_between(known, -1.0, prediction.span);
  const Eigen::VectorXd since = capture.times.array() - capture.times[0];
  const Eigen::VectorXd seen_times = known.times(before).array() - known.times[0];
  result.seen = {seen_times, measured(known, names, before)};
  if (!prediction.views.empty()) result.seen.views = views_shown(known, prediction.views, before);
  if (!predicted.attitude.empty()) result.turn = {seen_times, measured(known, predicted.attitude, before)};

  // What the fit of the span compares.
  const Eigen::MatrixXd values = result.seen.positions.leftCols(std::ssize(problem.outputs));
  const Eigen::MatrixXd attitudes =
      problem.attitude_scale ? Eigen::MatrixXd(result.turn.attitudes) : Eigen::MatrixXd();
  Motion motion;
  if (problem.delay) motion.known = known_values(with_measurement(family.info(), options), known, options);
  const models::Interval delay = delay_range(problem, motion);
  const double last = last_time(family.info(), options, known, delay, before, values, attitudes);
  const double wanted = prediction.span + prediction.ahead;
  const double end = std::min(wanted, last - capture.times[0]);
  const std::vector<Eigen::Index> after = frames_between(capture, prediction.span, end);
  result.is_cut = frames_between(capture, prediction.span, wanted).size() > after.size();
  result.times = since(after);
  result.truth = measured(capture, names, after);
  result.truth_attitude = Eigen::MatrixX4d::Constant(std::ssize(after), 4, kNaN);
  if (!predicted.attitude.empty()) result.truth_attitude = measured(capture, predicted.attitude, after);
  if (!can_be_fitted(values, attitudes, unknowns)) {
    result.lack = fmt::format("its first {} s, {} frames, hold too little to fit its {} unknowns",
                              prediction.span, before.size(), unknowns);
  } else if (after.empty() && result.is_cut) {
    result.lack =
        fmt::format("the {} ends at {:.4g} s of its times and the span at {:.4g} s, with no frame between",
                    family.info().source, last, capture.times[0] + prediction.span);
  } else if (after.empty()) {
    result.lack = fmt::format("it has no frame between {} s and {} s", prediction.span, end);
  }
  if (!result.lack.empty()) return result;
  add_rates(family, known, predicted, before, result);
  if (asks_model)
    carry_on(family, known, predicted, options, unknowns, capture.times(after).cwiseMin(last), result);
  return result;
}

}  // namespace samara::identification
