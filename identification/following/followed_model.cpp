#include "samara/identification/following/followed_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"
#include "samara/base/units.h"
#include "samara/identification/problem/chart.h"
#include "samara/models/integrators/rotations.h"

namespace samara::identification {

namespace {

std::string initial_name(const std::string& state) {
  return state + "(0)";
}

void check_follow_options(const FollowOptions& options) {
  constexpr const char* kWhere = "following a motion";
  for (const auto& [name, noise] : options.noise) require_positive(noise, "noise of " + name, kWhere);
  if (options.attitude_noise) require_positive(*options.attitude_noise, "noise of the attitude", kWhere);
  for (const auto& [name, period] : options.periods)
    require_not_negative(period, "period of " + name, kWhere);
  require(options.averaged_frames >= 1 && options.averaged_frames % 2 == 1, "averaged_frames",
          options.averaged_frames, "an odd number from 1 on", kWhere);
  require_not_negative(options.model_noise.velocity, "model_noise.velocity", kWhere);
  require_not_negative(options.model_noise.rate, "model_noise.rate", kWhere);
  for (const auto& [name, noise] : options.model_noise.states)
    require_not_negative(noise, "model noise of " + name, kWhere);
  require_positive(options.step, "step", kWhere);
  for (const auto& [name, start] : options.start) {
    require(std::isfinite(start.mean), "start of " + name, start.mean, "a finite value", kWhere);
    require_not_negative(start.deviation, "deviation of the start of " + name, kWhere);
  }
  for (const FollowedCoefficient& c : options.coefficients) {
    require(std::isfinite(c.value) && (!c.logarithmic || c.value > 0.0), c.name, c.value,
            c.logarithmic ? "a positive value" : "a finite value", kWhere);
    require_not_negative(c.deviation, "deviation of " + c.name, kWhere);
    require_not_negative(c.drift, "drift of " + c.name, kWhere);
    require(c.value >= c.lower && c.value <= c.upper, c.name, c.value, "a value within its bounds", kWhere);
  }
  require(options.start_frames >= 1, "start_frames", options.start_frames, "1 or more", kWhere);
  const Eigen::Index count = std::ssize(options.coefficients);
  const Eigen::MatrixXd& covariance = options.coefficient_covariance;
  if (covariance.size() == 0) return;
  if (covariance.rows() != count || covariance.cols() != count || !covariance.allFinite()) {
    throw ArgumentError(
        fmt::format("the covariance of coefficients is {} x {}; finite and {} x {} was expected",
                    covariance.rows(), covariance.cols(), count, count));
  }
}

/// The model with every initial value and the followed coefficients free.
models::ParametricModel free_model(std::shared_ptr<const models::Model> model, const FollowOptions& options) {
  check_follow_options(options);
  std::vector<std::string> free;
  for (const models::StateInfo& state : model->info().states) free.push_back(initial_name(state.name));
  std::map<std::string, double> fixed;
  for (const auto& [name, value] : options.fixed) {
    if (std::ranges::count(free, name) == 0) fixed.emplace(name, value);
  }
  for (const FollowedCoefficient& c : options.coefficients) {
    const bool is_parameter =
        std::ranges::any_of(model->info().parameters,
                            [&](const models::ParameterInfo& parameter) { return parameter.name == c.name; });
    if (!is_parameter) {
      std::vector<std::string> known;
      for (const models::ParameterInfo& parameter : model->info().parameters) known.push_back(parameter.name);
      throw ArgumentError(fmt::format("the model \"{}\" has no parameter \"{}\" to follow{}",
                                      model->info().name, c.name, suggestion(c.name, known)));
    }
    free.push_back(c.name);
  }
  return {std::move(model), fixed, free};
}

Eigen::Matrix<double, 4, 3> quaternion_by_turn(const double* q) {
  Eigen::Matrix<double, 4, 3> by_turn;
  by_turn << -q[1], -q[2], -q[3],  //
      q[0], -q[3], q[2],           //
      q[3], q[0], -q[1],           //
      -q[2], q[1], q[0];
  return 0.5 * by_turn;
}

}  // namespace

Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& rotation) {
  const double angle2 = rotation.squaredNorm();
  const double angle = std::sqrt(angle2);
  Eigen::Matrix3d cross;
  cross << 0.0, -rotation.z(), rotation.y(),  //
      rotation.z(), 0.0, -rotation.x(),       //
      -rotation.y(), rotation.x(), 0.0;
  // Below 1e-4 the next terms of the series are less than round-off.
  const double first = angle < 1e-4 ? 0.5 : (1.0 - std::cos(angle)) / angle2;
  const double second = angle < 1e-4 ? 1.0 / 6.0 : (angle - std::sin(angle)) / (angle2 * angle);
  return Eigen::Matrix3d::Identity() - first * cross + second * cross * cross;
}

double ModelNoise::*noise_by_unit(const models::StateInfo& state) {
  if (!is_coherent_si(state.unit)) return nullptr;  // a unit of the model's own, such as a number of animals
  if (same_dimension(state.unit, "m/s")) return &ModelNoise::velocity;
  if (same_dimension(state.unit, "rad/s")) return &ModelNoise::rate;
  return nullptr;
}

FollowedModel::FollowedModel(std::shared_ptr<const models::Model> model, const FollowOptions& options)
    : options_(options),
      equations_(free_model(std::move(model), options)),
      states_(equations_.state_count()),
      coefficients_(std::ssize(options.coefficients)) {
  const models::ModelInfo& info = equations_.model().info();
  for (const models::StateGroup& group : info.groups) {
    if (group.kind == models::StateGroupKind::quaternion && !attitude_) attitude_ = group.first;
  }
  std::vector<std::string> states;
  for (Eigen::Index i = 0; i < states_; ++i) {
    const std::string& name = info.states[static_cast<std::size_t>(i)].name;
    states.push_back(name);
    if (attitude_ && i >= *attitude_ && i < *attitude_ + 4) {
      constexpr const char* kTurns[] = {"turn about x", "turn about y", "turn about z"};
      if (i < *attitude_ + 3) error_names_.emplace_back(kTurns[i - *attitude_]);
    } else {
      error_names_.push_back(name);
    }
  }
  for (const FollowedCoefficient& c : options_.coefficients) error_names_.push_back(c.name);
  const auto check_states = [&](const auto& named, const char* what) {
    for (const auto& [name, value] : named) {
      if (std::ranges::count(states, name) == 0) {
        throw ArgumentError(fmt::format("{} of \"{}\": the model \"{}\" has no such state{}", what, name,
                                        info.name, suggestion(name, states)));
      }
    }
  };
  check_states(options_.start, "the start");
  check_states(options_.model_noise.states, "model noise");
  if (attitude_is_measured() && !attitude_)
    throw ArgumentError(fmt::format("the model \"{}\" has no attitude to be measured", info.name));
  resolve_outputs();
  resolve_noise();
}

void FollowedModel::resolve_outputs() {
  for (const auto& [name, noise] : options_.noise) {
    SeenOutput seen = output(name);
    seen.noise = noise;
    const bool of_attitude =
        seen.is_state && attitude_ && seen.index >= *attitude_ && seen.index < *attitude_ + 4;
    if (of_attitude) {
      throw ArgumentError(
          fmt::format("\"{}\" is a part of the attitude, which is compared by its turn; "
                      "attitude_noise was expected",
                      name));
    }
    measured_.push_back(std::move(seen));
  }
  if (compared() == 0)
    throw ArgumentError("nothing is measured; the noise of one output was expected at least");
}

SeenOutput FollowedModel::output(const std::string& name) const {
  const models::ModelInfo& info = equations_.model().info();
  std::vector<std::string> known;
  const auto found = [&](bool is_state, std::size_t index, const std::string& unit) {
    SeenOutput seen{.name = name, .is_state = is_state, .index = static_cast<Eigen::Index>(index)};
    const auto period = options_.periods.find(name);
    seen.period = period != options_.periods.end() ? period->second
                  : unit == "rad"                  ? 2.0 * std::numbers::pi
                                                   : 0.0;
    return seen;
  };
  for (std::size_t i = 0; i < info.states.size(); ++i) {
    if (info.states[i].name == name) return found(true, i, info.states[i].unit);
    known.push_back(info.states[i].name);
  }
  for (std::size_t i = 0; i < info.outputs.size(); ++i) {
    if (info.outputs[i].name == name) return found(false, i, info.outputs[i].unit);
    known.push_back(info.outputs[i].name);
  }
  throw ArgumentError(
      fmt::format("the model \"{}\" has no output \"{}\"{}", info.name, name, suggestion(name, known)));
}

void FollowedModel::resolve_noise() {
  noise_rates_.setZero(errors());
  const auto& states = equations_.model().info().states;
  for (Eigen::Index i = 0; i < states_; ++i) {
    if (attitude_ && i >= *attitude_ && i < *attitude_ + 4) continue;
    const models::StateInfo& state = states[static_cast<std::size_t>(i)];
    const auto by_unit = noise_by_unit(state);
    double noise = by_unit != nullptr ? options_.model_noise.*by_unit : 0.0;
    const auto given = options_.model_noise.states.find(state.name);
    if (given != options_.model_noise.states.end()) noise = given->second;
    noise_rates_[error_of_state(i)] = noise * noise;
  }
  for (Eigen::Index j = 0; j < coefficients_; ++j) {
    const double drift = options_.coefficients[static_cast<std::size_t>(j)].drift;
    noise_rates_[error_of_coefficient(j)] = drift * drift;
  }
}

Eigen::Index FollowedModel::error_of_state(Eigen::Index state) const {
  return attitude_ && state >= *attitude_ + 4 ? state - 1 : state;
}

void FollowedModel::plus(const Eigen::VectorXd& from, const Eigen::VectorXd& error,
                         Eigen::VectorXd& to) const {
  for (Eigen::Index i = 0; i < states_; ++i) {
    if (attitude_ && i == *attitude_) {
      const models::Quaternion turned = models::normalised(
          models::product({from[i], from[i + 1], from[i + 2], from[i + 3]},
                          models::rotation_exponential({error[i], error[i + 1], error[i + 2]})));
      for (Eigen::Index part = 0; part < 4; ++part) to[i + part] = turned[static_cast<std::size_t>(part)];
      i += 3;
    } else {
      to[i] = from[i] + error[error_of_state(i)];
    }
  }
  for (Eigen::Index j = 0; j < coefficients_; ++j) {
    const FollowedCoefficient& c = options_.coefficients[static_cast<std::size_t>(j)];
    const double step = error[error_of_coefficient(j)];
    const double start = from[states_ + j];
    to[states_ + j] = std::clamp(c.logarithmic ? start * std::exp(step) : start + step, c.lower, c.upper);
  }
}

void FollowedModel::minus(const Eigen::VectorXd& to, const Eigen::VectorXd& from,
                          Eigen::VectorXd& error) const {
  for (Eigen::Index i = 0; i < states_; ++i) {
    if (attitude_ && i == *attitude_) {
      error.segment<3>(i) = turn_between(from.data() + i, to.data() + i).vector;
      i += 3;
    } else {
      error[error_of_state(i)] = to[i] - from[i];
    }
  }
  for (Eigen::Index j = 0; j < coefficients_; ++j) {
    const double a = from[states_ + j], b = to[states_ + j];
    error[error_of_coefficient(j)] =
        options_.coefficients[static_cast<std::size_t>(j)].logarithmic ? std::log(b / a) : b - a;
  }
}

void FollowedModel::times_plus(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& at,
                               Eigen::MatrixXd& product) const {
  const Eigen::Index before = attitude_.value_or(states_);
  product.leftCols(before) = matrix.leftCols(before);
  if (attitude_) {
    product.middleCols<3>(before).noalias() =
        matrix.middleCols<4>(before).lazyProduct(quaternion_by_turn(at.data() + before));
    const Eigen::Index after = states_ - before - 4;
    product.middleCols(before + 3, after) = matrix.middleCols(before + 4, after);
  }
  for (Eigen::Index j = 0; j < coefficients_; ++j) {
    const double slope =
        options_.coefficients[static_cast<std::size_t>(j)].logarithmic ? at[states_ + j] : 1.0;
    product.col(error_of_coefficient(j)) = slope * matrix.col(states_ + j);
  }
}

void FollowedModel::minus_times(const Eigen::VectorXd& at, const Eigen::MatrixXd& matrix,
                                Eigen::MatrixXd& product) const {
  const Eigen::Index before = attitude_.value_or(states_);
  product.topRows(before) = matrix.topRows(before);
  if (!attitude_) return;
  // Of q of length n: turn = 2 vec(conj(q) dq)/n^2, four times the transpose of the derivative the other way.
  const double norm2 = at.segment<4>(before).squaredNorm();
  const Eigen::Matrix<double, 3, 4> by_quaternion =
      4.0 / norm2 * quaternion_by_turn(at.data() + before).transpose();
  product.middleRows<3>(before).noalias() = by_quaternion.lazyProduct(matrix.middleRows<4>(before));
  const Eigen::Index after = states_ - before - 4;
  product.middleRows(before + 3, after) = matrix.middleRows(before + 4, after);
}

void FollowedModel::carry(const Eigen::VectorXd& error, Eigen::MatrixXd& covariance,
                          Eigen::MatrixXd& scratch) const {
  if (!attitude_) return;
  const Eigen::Index at = *attitude_;
  const Eigen::Matrix3d turned = right_jacobian(error.segment<3>(at));
  scratch = covariance;
  scratch.middleRows<3>(at).noalias() = turned.lazyProduct(covariance.middleRows<3>(at));
  covariance = scratch;
  covariance.middleCols<3>(at).noalias() = scratch.middleCols<3>(at).lazyProduct(turned.transpose());
}

}  // namespace samara::identification
