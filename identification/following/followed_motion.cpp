#include "samara/identification/following/followed_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"
#include "samara/base/unit_labels.h"
#include "samara/identification/following/followed_model.h"
#include "samara/identification/problem/known_so_far.h"
#include "samara/identification/problem/known_values.h"
#include "samara/identification/problem/measurement.h"
#include "samara/identification/problem/segments.h"

namespace samara::identification {

namespace {

constexpr const char* kInitial = "(0)";
const double kNotFollowed = std::numeric_limits<double>::quiet_NaN();

std::string state_name(const std::string& initial) {
  return initial.substr(0, initial.size() - std::string(kInitial).size());
}

bool is_state(const models::ModelInfo& info, const std::string& name) {
  return std::ranges::any_of(info.states, [&](const models::StateInfo& state) { return state.name == name; });
}

bool is_parameter(const models::ModelInfo& info, const std::string& name) {
  return std::ranges::any_of(info.parameters,
                             [&](const models::ParameterInfo& parameter) { return parameter.name == name; });
}

/// Of a state, parameter or output.
std::string unit_of(const models::ModelInfo& info, const std::string& name) {
  for (const models::StateInfo& state : info.states) {
    if (state.name == name) return state.unit;
  }
  for (const models::ParameterInfo& parameter : info.parameters) {
    if (parameter.name == name) return parameter.unit;
  }
  for (const models::OutputInfo& output : info.outputs) {
    if (output.name == name) return output.unit;
  }
  return "1";
}

/// The states of the attitude; empty if there is none.
std::vector<std::string> attitude_of(const models::ModelInfo& info) {
  std::vector<std::string> names;
  for (const models::StateGroup& group : info.groups) {
    if (group.kind != models::StateGroupKind::quaternion || !names.empty()) continue;
    for (int part = 0; part < 4; ++part)
      names.push_back(info.states[static_cast<std::size_t>(group.first + part)].name);
  }
  return names;
}

/// Standard deviation of a frame, SI; of an attitude about each axis.
double noise_of(const FitResult& fitted, const std::string& output) {
  for (const NoiseLevel& level : fitted.noise) {
    if (contains(level.outputs, output) && level.value > 0.0) return level.value;
  }
  for (const OutputRms& residual : fitted.residuals) {
    // Of an attitude it is that of the whole turn.
    if (residual.output == output && residual.rms > 0.0)
      return output == "attitude" ? residual.rms / std::sqrt(3.0) : residual.rms;
  }
  throw ArgumentError(fmt::format(
      "the fit says nothing of the noise of \"{}\"; a noise level or a residual was expected", output));
}

bool is_delay_or_gain(const std::string& name) {
  return name == kDelay || name.starts_with(gain_name(""));
}

/// One that changes nothing may be held.
void refuse_held(const std::string& name, double value) {
  const double nothing = name == kDelay ? 0.0 : 1.0;
  if (value == nothing) return;
  throw ArgumentError(fmt::format(
      "the fit holds \"{}\" at {}; {} was expected, since frames are followed without delay and gains", name,
      value, nothing));
}

void refuse_unfollowed(const FitResult& fitted, const models::ModelInfo& info) {
  if (fitted.status == Termination::failed)
    throw ArgumentError(fmt::format("a fit that failed cannot be followed: {}", fitted.message));
  for (const auto& names : {fitted.setup.unknowns.shared, fitted.setup.unknowns.per_capture}) {
    for (const std::string& name : names) {
      if (is_delay_or_gain(name))
        throw ArgumentError(
            fmt::format("the fit has an unknown \"{}\"; one without delay and gains was expected", name));
    }
  }
  for (const std::string& offset : fitted.setup.unknowns.offsets.value_or(std::vector<std::string>())) {
    const bool is_place = std::ranges::count(info.symmetries, "translation of " + offset) > 0;
    if (!is_place) {
      throw ArgumentError(
          fmt::format("the fit has an offset of \"{}\", on which the motion depends; offsets of places "
                      "alone were expected",
                      offset));
    }
  }
}

void add_outputs(const models::ModelInfo& info, const FitResult& fitted, const Capture& capture,
                 FollowOptions& options) {
  const std::vector<std::string> attitude = attitude_of(info);
  int parts = 0;
  for (const std::string& output : fitted.setup.compared.outputs) {
    if (!capture.has(output)) continue;
    if (contains(attitude, output)) {
      if (++parts == 4) options.attitude_noise = noise_of(fitted, "attitude");
    } else {
      options.noise[output] = noise_of(fitted, output);
    }
  }
  if (options.noise.empty() && !options.attitude_noise) {
    refuse(capture.file, fmt::format("the capture \"{}\" measures nothing of what was fitted: {}", capture.id,
                                     join(fitted.setup.compared.outputs)));
  }
}

/// A normal distribution of what may lie anywhere in a box, or of what a prior says.
FollowedStart start_in(const FitOptions& setup, const std::string& name) {
  const auto prior = setup.priors.coordinates.find(name);
  if (prior != setup.priors.coordinates.end()) return {prior->second.mean, standard_deviation(prior->second)};
  const auto box = setup.unknowns.box.find(name);
  if (box == setup.unknowns.box.end())
    throw ArgumentError(fmt::format("the fit has no box of \"{}\"; one was expected", name));
  const auto& [lower, upper] = box->second;
  return {0.5 * (lower + upper), (upper - lower) / std::sqrt(12.0)};
}

void add_own(const models::ModelInfo& info, const FitResult& fitted, FollowOptions& options) {
  const std::vector<std::string> attitude = attitude_of(info);
  for (const std::string& name : fitted.setup.unknowns.per_capture) {
    if (name.ends_with(kInitial) && is_state(info, state_name(name))) {
      const std::string state = state_name(name);
      const bool has_prior = fitted.setup.priors.coordinates.contains(name);
      options.fixed.erase(name);
      if (contains(attitude, state) || (options.noise.contains(state) && !has_prior)) continue;
      options.start[state] = start_in(fitted.setup, name);
    } else if (is_parameter(info, name)) {
      const FollowedStart start = start_in(fitted.setup, name);
      FollowedCoefficient own{.name = name, .value = start.mean, .deviation = start.deviation, .own = true};
      const auto box = fitted.setup.unknowns.box.find(name);
      if (box != fitted.setup.unknowns.box.end()) {
        own.lower = box->second.lower;
        own.upper = box->second.upper;
      }
      options.coefficients.push_back(own);
    }
  }
}

/// Whether the value of the fit is taken as exact.
bool is_held(const models::ModelInfo& info, const Coefficient& c) {
  return c.at_bound || !is_parameter(info, c.name);
}

/// Of the step of a coefficient, no farther than its box goes.
double step_deviation(const FollowedCoefficient& c, double error) {
  const double box = c.logarithmic ? std::log(c.upper / c.lower) : c.upper - c.lower;
  return std::min(error / (c.logarithmic ? c.value : 1.0), box / std::sqrt(12.0));
}

/// Those that are not held are followed; how far off they may be is what the fit knows of them.
void add_coefficients(const models::ModelInfo& info, const FitResult& fitted, FollowOptions& options) {
  if (fitted.coefficients.empty()) return;
  const KnownSoFar known = known_so_far(fitted);
  const auto own = std::ssize(options.coefficients);
  std::vector<Eigen::Index> followed;
  for (Eigen::Index k = 0; k < known.values.size(); ++k) {
    const Coefficient& c = fitted.coefficients[static_cast<std::size_t>(k)];
    if (is_held(info, c)) {
      options.fixed[c.name] = c.value;
      continue;
    }
    followed.push_back(k);
    FollowedCoefficient coefficient{
        .name = c.name, .value = c.value, .logarithmic = c.lower > 0.0, .lower = c.lower, .upper = c.upper};
    coefficient.deviation = step_deviation(coefficient, known.widened[k]);
    options.coefficients.push_back(coefficient);
  }
  const auto total = std::ssize(options.coefficients);
  Eigen::VectorXd deviations(total);
  for (Eigen::Index j = 0; j < total; ++j)
    deviations[j] = options.coefficients[static_cast<std::size_t>(j)].deviation;
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(total, total);
  correlation.bottomRightCorner(total - own, total - own) = known.correlation(followed, followed);
  options.coefficient_covariance = deviations.asDiagonal() * correlation * deviations.asDiagonal();
}

}  // namespace

FollowOptions follow_options(const models::Model& model, const FitResult& fitted, const Capture& capture) {
  const models::ModelInfo& info = model.info();
  refuse_unfollowed(fitted, info);
  FollowOptions options;
  options.averaged_frames = fitted.setup.compared.averaged_frames;
  options.periods = fitted.setup.compared.periods;
  options.round_body = fitted.setup.starts.round_body;
  if (fitted.setup.solver.step) options.step = *fitted.setup.solver.step;
  for (const auto& held : {fitted.fixed, fitted.setup.unknowns.fixed}) {
    for (const auto& [name, value] : held) {
      if (is_delay_or_gain(name)) refuse_held(name, value);
      const bool is_start = name.ends_with(kInitial) && is_state(info, state_name(name));
      if (is_start || is_parameter(info, name)) options.fixed[name] = value;
    }
  }
  for (const auto& [name, known] : fitted.setup.unknowns.known) {
    const double value = known_value(capture, name, known);
    if (is_delay_or_gain(name)) {
      refuse_held(name, value);
    } else {
      options.fixed[name] = value;
    }
  }
  add_outputs(info, fitted, capture, options);
  for (const std::string& offset : fitted.setup.unknowns.offsets.value_or(std::vector<std::string>()))
    options.fixed.erase(offset + kInitial);  // the place is what the frames say
  add_own(info, fitted, options);
  add_coefficients(info, fitted, options);
  // What turns a round body about its axis cannot be seen, and must not wander.
  for (const models::StateInfo& state : info.states) {
    const bool is_rate = noise_by_unit(state) == &ModelNoise::rate;
    if (options.round_body && is_rate && options.fixed.contains(state.name + kInitial))
      options.model_noise.states[state.name] = 0.0;
  }
  return options;
}

Warnings warnings_of_coefficients(const models::Model& model, const FitResult& fitted) {
  const models::ModelInfo& info = model.info();
  Warnings warnings;
  for (const Coefficient& c : fitted.coefficients) {
    const std::string value = fmt::format("{:.6g}{}", c.value, unit_suffix(c.unit));
    if (c.at_bound) {
      warnings.add(WarningKind::bounds, fmt::format("{} lies at a bound of its box in the fit: it is held at "
                                                    "{}, as if it were known exactly",
                                                    c.name, value));
    } else if (is_held(info, c)) {
      warnings.add(WarningKind::errors, fmt::format("{} was one for all captures of the fit: it is held at "
                                                    "{}, as if it were known exactly",
                                                    c.name, value));
    } else if (!c.determined || (!c.standard_error && !c.naive_standard_error)) {
      warnings.add(WarningKind::undetermined,
                   fmt::format("the fit does not determine {}: it begins at {}, and "
                               "may lie anywhere in its box",
                               c.name, value));
    }
  }
  return warnings;
}

Eigen::MatrixXd frames_of(const Follower& follower, const models::ModelInfo& info, const Capture& capture) {
  const std::vector<std::string>& measured = follower.measured();
  Eigen::MatrixXd values =
      Eigen::MatrixXd::Constant(capture.times.size(), std::ssize(measured), kNotFollowed);
  bool any = false;
  for (std::size_t k = 0; k < measured.size(); ++k) {
    if (!capture.has(measured[k])) continue;
    any = true;
    values.col(static_cast<Eigen::Index>(k)) =
        compared_channel(capture, measured[k], unit_of(info, measured[k])).values;
  }
  if (!any) {
    refuse(capture.file, fmt::format("the capture \"{}\" measures nothing of what is followed: {}",
                                     capture.id, join(measured)));
  }
  // An attitude of which a part is missing counts as not seen.
  const std::vector<std::string> attitude = attitude_of(info);
  if (!attitude.empty() && std::ranges::count(measured, attitude.front()) > 0) {
    for (Eigen::Index row = 0; row < values.rows(); ++row) {
      if (values.row(row).tail(4).hasNaN()) values.row(row).tail(4).setConstant(kNotFollowed);
    }
  }
  return values;
}

FollowedFrame add_frame(Follower& follower, const Capture& capture, const Eigen::MatrixXd& values,
                        Eigen::Index row) {
  const Eigen::RowVectorXd frame = values.row(row);
  try {
    return follower.add(capture.times[row], {frame.data(), static_cast<std::size_t>(frame.size())});
  } catch (const ArgumentError& error) {
    refuse(capture.file, fmt::format("capture \"{}\": {}", capture.id, error.what()));
  }
}

void check_steps(const FollowOptions& options, const Capture& capture, double ahead) {
  constexpr double kMostSteps = 1e10;  // an hour
  const auto frames = static_cast<double>(capture.times.size());
  const double covered =
      (frames > 0.0 ? capture.times[capture.times.size() - 1] - capture.times[0] : 0.0) + frames * ahead;
  if (covered <= kMostSteps * options.step) return;
  throw ArgumentError(fmt::format(
      "steps of {} s through \"{}\", {} s ahead of each frame, are more than {:.0e}; a longer step or less "
      "ahead was expected",
      options.step, capture.id, ahead, kMostSteps));
}

FollowedMotion follow(std::shared_ptr<const models::Model> model, const FollowOptions& options,
                      const Capture& capture, double ahead) {
  require_not_negative(ahead, "ahead", "follow");
  const models::ModelInfo& info = model->info();
  FollowedMotion motion{.capture = capture.id, .times = capture.times, .ahead = ahead};
  for (const models::StateInfo& state : info.states) {
    motion.names.push_back(state.name);
    motion.units.push_back(state.unit);
  }
  for (const FollowedCoefficient& c : options.coefficients) {
    motion.names.push_back(c.name);
    motion.units.push_back(unit_of(info, c.name));
  }
  FollowOptions remembered = options;
  remembered.remember = true;
  Follower follower(model, remembered);
  check_steps(options, capture, ahead);
  const Eigen::MatrixXd values = frames_of(follower, info, capture);
  const Eigen::Index rows = capture.times.size(), columns = std::ssize(motion.names);
  for (Eigen::MatrixXd* table :
       {&motion.values, &motion.errors, &motion.smoothed_values, &motion.smoothed_errors})
    table->setConstant(rows, columns, kNotFollowed);
  motion.state_times.setConstant(rows, kNotFollowed);
  const auto put = [&](const FollowedState& state, Eigen::Index row, Eigen::MatrixXd& to,
                       Eigen::MatrixXd& errors) {
    to.row(row) << state.states.transpose(), state.coefficients.transpose();
    errors.row(row) = follower.deviations(state).transpose();
  };
  if (ahead > 0.0) {
    for (const auto& [name, noise] : options.noise) {
      motion.outputs.push_back(name);
      motion.output_units.push_back(unit_of(info, name));
    }
  }
  for (Eigen::MatrixXd* table : {&motion.forecasts.mean, &motion.forecasts.lower, &motion.forecasts.upper})
    table->setConstant(rows, std::ssize(motion.outputs), kNotFollowed);
  for (Eigen::Index row = 0; row < rows; ++row) {
    motion.frames.push_back(add_frame(follower, capture, values, row));
    motion.log_likelihood += motion.frames.back().log_likelihood;
    if (!follower.is_following()) continue;
    const FollowedState state = follower.state();
    motion.state_times[row] = state.time;
    put(state, row, motion.values, motion.errors);
    if (motion.outputs.empty()) continue;
    const ForecastBand band = band_of(follower.forecast(std::array{capture.times[row] + ahead}));
    motion.forecasts.mean.row(row) = band.mean.row(0);
    motion.forecasts.lower.row(row) = band.lower.row(0);
    motion.forecasts.upper.row(row) = band.upper.row(0);
  }
  // States lie a constant time before their frames.
  double lead = 0.0;
  for (Eigen::Index row = 0; row < rows; ++row) {
    if (!std::isnan(motion.state_times[row])) lead = motion.times[row] - motion.state_times[row];
  }
  motion.state_times = motion.times.array() - lead;
  Eigen::Index row = 0;
  for (const FollowedState& state : follower.smoothed()) {
    while (row + 1 < rows && std::abs(motion.state_times[row] - state.time) >
                                 std::abs(motion.state_times[row + 1] - state.time))
      ++row;
    put(state, row, motion.smoothed_values, motion.smoothed_errors);
  }
  return motion;
}

}  // namespace samara::identification
