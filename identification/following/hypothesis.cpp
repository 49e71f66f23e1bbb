#include "samara/identification/following/hypothesis.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "samara/identification/problem/chart.h"
#include "samara/identification/statistics/quantiles.h"

namespace samara::identification {

namespace {

/// A frame interval is one part, also where a frame comes a little late.
constexpr double kLongestPart = 1.5;
/// Of a standard error: an update that moves by less has settled.
constexpr double kSettled = 1e-3;
/// Of an update, at most.
constexpr int kUpdateIterations = 3;
/// A frame whose normalised innovation squared is beyond this quantile of its chi^2 distribution is an outlier: it
/// counts with its noise raised until it is at that quantile.
constexpr double kGate = 0.9999;

std::vector<int> all_directions(const FollowedModel& model) {
  std::vector<int> directions(static_cast<std::size_t>(model.size()));
  std::iota(directions.begin(), directions.end(), 0);
  return directions;
}

std::span<const double> as_span(const Eigen::VectorXd& vector) {
  return {vector.data(), static_cast<std::size_t>(vector.size())};
}

std::span<double> states_of(Eigen::VectorXd& point, Eigen::Index count) {
  return {point.data(), static_cast<std::size_t>(count)};
}

}  // namespace

HypothesisFilter::HypothesisFilter(const FollowedModel& model)
    : model_(model),
      flow_(model.equations(), model.options().step, all_directions(model)),
      seen_flow_(model.equations(), model.options().step, all_directions(model)),
      plain_flow_(model.equations(), model.options().step, {}),
      workspace_(model.equations().make_workspace()) {
  const Eigen::Index size = model.size(), states = model.states(), errors = model.errors();
  const models::ModelInfo& info = model.equations().model().info();
  const Eigen::Index rows = model.compared();
  gates_.assign(1, 0.0);
  for (Eigen::Index count = 1; count <= rows; ++count) {
    gates_.push_back(chi_squared_quantile(static_cast<double>(count), kGate));
  }
  for (Eigen::VectorXd* vector : {&moved_, &point_}) vector->setZero(size);
  for (Eigen::VectorXd* vector : {&error_, &step_}) vector->setZero(errors);
  for (Eigen::VectorXd* vector : {&residuals_, &innovations_, &variances_}) vector->setZero(rows);
  expected_.setZero(std::ssize(model.measured()) + (model.attitude_is_measured() ? 4 : 0));
  for (Eigen::MatrixXd* matrix : {&transition_, &scratch_, &half_, &joseph_}) matrix->setZero(errors, errors);
  by_flow_.setZero(states, size);
  by_start_.setZero(states, errors);
  outputs_.setZero(std::ssize(info.outputs));
  outputs_by_time_.setZero(outputs_.size());
  outputs_by_states_.setZero(outputs_.size(), states);
  outputs_by_parameters_.setZero(outputs_.size(), std::ssize(info.parameters));
  by_point_.setZero(expected_.size(), size);
  seen_by_errors_.setZero(expected_.size(), errors);
  by_errors_.setZero(rows, errors);
  for (Eigen::MatrixXd* matrix : {&cross_, &gain_}) matrix->setZero(rows, errors);
  innovation_covariance_.setZero(rows, rows);
  llt_.compute(Eigen::MatrixXd::Identity(rows, rows));  // memory for all that follow
}

void HypothesisFilter::set_interval(double interval) {
  interval_ = interval;
}

double HypothesisFilter::lead() const {
  return 0.5 * (model_.options().averaged_frames - 1) * interval_;
}

bool HypothesisFilter::predict(Hypothesis& hypothesis, double t, double duration,
                               Eigen::MatrixXd* transition) {
  const Eigen::Index states = model_.states();
  const Eigen::Index moving = model_.errors() - model_.coefficients();
  const double count =
      interval_ > 0.0 ? std::max(1.0, std::ceil(duration / (kLongestPart * interval_) - 1e-9)) : 1.0;
  const double part = duration / count;
  if (transition) transition->setIdentity();
  for (double n = 0.0; n < count; n += 1.0) {
    flow_.start(as_span(hypothesis.point), t + n * part);
    if (!flow_.advance(part)) return false;
    moved_ = hypothesis.point;
    flow_.read(states_of(moved_, states));
    flow_.read_derivatives(by_flow_);
    model_.times_plus(by_flow_, hypothesis.point, by_start_);
    transition_.setIdentity();
    model_.minus_times(moved_, by_start_, half_);  // into its upper rows
    transition_.topRows(moving) = half_.topRows(moving);
    if (const auto at = model_.attitude()) moved_.segment<4>(*at).normalize();
    if (!transition_.allFinite() || !moved_.allFinite()) return false;
    hypothesis.point = moved_;
    scratch_.noalias() = transition_ * hypothesis.covariance;
    hypothesis.covariance.noalias() = scratch_ * transition_.transpose();
    add_noise(part, hypothesis.covariance);
    if (transition) {
      scratch_.noalias() = transition_ * *transition;
      *transition = scratch_;
    }
  }
  scratch_ = hypothesis.covariance.transpose();
  hypothesis.covariance = 0.5 * (hypothesis.covariance + scratch_);
  return true;
}

bool HypothesisFilter::move(Eigen::VectorXd& point, double t, double duration) {
  plain_flow_.start(as_span(point), t);
  if (!plain_flow_.advance(duration)) return false;
  plain_flow_.read(states_of(point, model_.states()));
  if (const auto at = model_.attitude()) point.segment<4>(*at).normalize();
  return true;
}

/// Integral of Phi W Phi^T over the part by Simpson's rule, Phi half-way being the mean of both ends: exact where
/// rates are added up, one integral after another.
void HypothesisFilter::add_noise(double duration, Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd& rates = model_.noise_rates();
  const double share = duration / 6.0;
  half_ = transition_;
  half_.diagonal().array() += 1.0;
  scratch_.noalias() = half_ * rates.asDiagonal();
  covariance.noalias() += share * scratch_ * half_.transpose();
  scratch_.noalias() = transition_ * rates.asDiagonal();
  covariance.noalias() += share * scratch_ * transition_.transpose();
  covariance.diagonal() += share * rates;
}

bool HypothesisFilter::observe(const Eigen::VectorXd& point, double t, const std::vector<SeenOutput>& outputs,
                               bool attitude, Eigen::VectorXd& values, Eigen::MatrixXd* by_errors) {
  const models::ParametricModel& equations = model_.equations();
  const Eigen::Index states = model_.states(), own = std::ssize(outputs);
  const int samples = model_.options().averaged_frames;
  const double share = 1.0 / samples;
  const bool derived = std::ranges::any_of(outputs, [](const SeenOutput& o) { return !o.is_state; });
  if (by_errors) by_point_.setZero(own + (attitude ? 4 : 0), model_.size());
  values.setZero();
  if (derived) equations.parameter_values(as_span(point), workspace_.p);
  point_ = point;
  by_flow_.setIdentity();
  models::Rk4Flow& flow = by_errors ? seen_flow_ : plain_flow_;
  if (samples > 1) flow.start(as_span(point), t);
  for (int n = 0; n < samples; ++n) {
    if (n > 0) {
      if (!flow.advance(interval_)) return false;
      flow.read(states_of(point_, states));
      if (by_errors) flow.read_derivatives(by_flow_);
    }
    if (derived) {
      equations.model().outputs_with_derivatives(
          t + n * interval_, as_span(point_).first(static_cast<std::size_t>(states)), workspace_.p,
          states_of(outputs_, outputs_.size()), outputs_by_time_, outputs_by_states_, outputs_by_parameters_);
    }
    for (Eigen::Index row = 0; row < own; ++row) {
      const SeenOutput& output = outputs[static_cast<std::size_t>(row)];
      if (output.is_state) {
        values[row] += share * point_[output.index];
        if (by_errors) by_point_.row(row) += share * by_flow_.row(output.index);
        continue;
      }
      values[row] += share * outputs_[output.index];
      if (!by_errors) continue;
      by_point_.row(row).noalias() += share * outputs_by_states_.row(output.index).lazyProduct(by_flow_);
      for (Eigen::Index j = 0; j < model_.coefficients(); ++j) {
        const int parameter = equations.free()[static_cast<std::size_t>(states + j)].index;
        by_point_(row, states + j) += share * outputs_by_parameters_(output.index, parameter);
      }
    }
    if (!attitude) continue;
    values.segment<4>(own) += share * point_.segment<4>(*model_.attitude());
    if (by_errors) by_point_.middleRows<4>(own) += share * by_flow_.middleRows<4>(*model_.attitude());
  }
  if (!by_errors) return values.allFinite();
  model_.times_plus(by_point_, point, *by_errors);
  return values.allFinite() && by_errors->allFinite();
}

bool HypothesisFilter::compare(const Eigen::VectorXd& point, double t, const SeenFrame& frame,
                               Eigen::VectorXd& residuals, Eigen::MatrixXd* by_errors,
                               Eigen::VectorXd& variances) {
  const std::vector<SeenOutput>& measured = model_.measured();
  const bool attitude = model_.attitude_is_measured();
  if (!observe(point, t, measured, attitude, expected_, by_errors ? &seen_by_errors_ : nullptr)) return false;
  const Eigen::Index own = std::ssize(measured);
  residuals.setZero();
  if (by_errors) by_errors->setZero();
  variances.setOnes();
  for (Eigen::Index row = 0; row < own; ++row) {
    if (std::isnan(frame.values[row])) continue;
    const SeenOutput& output = measured[static_cast<std::size_t>(row)];
    const double difference = frame.values[row] - expected_[row];
    residuals[row] = output.period > 0.0 ? std::remainder(difference, output.period) : difference;
    if (by_errors) by_errors->row(row) = seen_by_errors_.row(row);
    variances[row] = output.noise * output.noise;
  }
  if (attitude && !frame.attitude.hasNaN()) {
    const Turn turn = turn_between(expected_.data() + own, frame.attitude.data());
    residuals.segment<3>(own) = turn.vector;
    if (by_errors)
      by_errors->middleRows<3>(own).noalias() =
          (-turn.by_from).lazyProduct(seen_by_errors_.middleRows<4>(own));
    variances.segment<3>(own).setConstant(*model_.options().attitude_noise *
                                          *model_.options().attitude_noise);
  }
  return true;
}

HypothesisFilter::Update HypothesisFilter::update(Hypothesis& hypothesis, double t, const SeenFrame& frame) {
  Update result;
  const Eigen::Index rows = model_.compared();
  moved_ = hypothesis.point;
  error_.setZero();
  double raised = 1.0;
  for (int iteration = 0; iteration < kUpdateIterations; ++iteration) {
    // What is seen is bent much less over one step than the motion to it: its first derivatives do for all iterations,
    // but for those of a turn, which the step may have turned far.
    const bool is_bent = iteration == 0 || model_.attitude_is_measured();
    if (!compare(moved_, t, frame, residuals_, is_bent ? &by_errors_ : nullptr, variances_))
      return {.is_finite = false};
    variances_ *= raised;
    half_ = hypothesis.covariance;
    model_.carry(error_, half_, scratch_);
    cross_.noalias() = by_errors_ * half_;
    innovation_covariance_.noalias() = cross_ * by_errors_.transpose();
    innovation_covariance_.diagonal() += variances_;
    llt_.compute(innovation_covariance_);
    if (llt_.info() != Eigen::Success) return {.is_finite = false};
    if (iteration == 0) {
      innovations_ = residuals_;
      llt_.matrixL().solveInPlace(innovations_);
      result.innovation_squared = innovations_.squaredNorm();
      const double at_most = gate(frame.count);
      double log_determinant = 0.0;
      for (Eigen::Index row = 0; row < rows; ++row)
        log_determinant += 2.0 * std::log(llt_.matrixLLT()(row, row));
      result.log_likelihood = -0.5 * (std::min(result.innovation_squared, at_most) + log_determinant +
                                      frame.count * std::log(2.0 * std::numbers::pi));
      if (result.innovation_squared > at_most) {
        result.is_outlier = true;
        raised = result.innovation_squared / at_most;
        innovation_covariance_.diagonal() += (raised - 1.0) * variances_;
        variances_ *= raised;
        llt_.compute(innovation_covariance_);
        if (llt_.info() != Eigen::Success) return {.is_finite = false};
      }
    }
    gain_ = cross_;
    llt_.solveInPlace(gain_);
    // About the point of this iteration the prior's mean lies at -error_.
    residuals_.noalias() += by_errors_ * error_;
    step_.noalias() = gain_.transpose() * residuals_;
    step_ -= error_;
    point_ = moved_;
    model_.plus(point_, step_, moved_);
    model_.minus(moved_, hypothesis.point, error_);
    if (!moved_.allFinite()) return {.is_finite = false};
    const bool settled =
        (step_.array().abs() <= kSettled * half_.diagonal().array().max(0.0).sqrt() + 1e-300).all();
    if (settled) break;
  }
  // Joseph's form stays symmetric and positive.
  transition_.setIdentity();
  transition_.noalias() -= gain_.transpose() * by_errors_;
  joseph_.noalias() = transition_ * half_;
  hypothesis.covariance.noalias() = joseph_ * transition_.transpose();
  cross_.noalias() = variances_.asDiagonal() * gain_;
  hypothesis.covariance.noalias() += gain_.transpose() * cross_;
  joseph_ = hypothesis.covariance.transpose();
  hypothesis.covariance = 0.5 * (hypothesis.covariance + joseph_);
  // So far of errors about the point before the last step.
  model_.carry(step_, hypothesis.covariance, scratch_);
  hypothesis.point = moved_;
  return result;
}

}  // namespace samara::identification
