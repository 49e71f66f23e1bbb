#include "samara/identification/following/forecast_component.h"

#include <cmath>
#include <limits>

#include "samara/identification/following/covariances.h"

namespace samara::identification {

namespace {

/// Squared distance of points, in deviations: that of a normal distribution's fourth moment.
constexpr double kDistance2 = 3.0;

/// Means and covariances by derivatives, without the noise of frames. @returns rows that are finite
Eigen::Index to_first_order(const FollowedModel& model, HypothesisFilter& filter, Hypothesis ahead,
                            double here, std::span<const double> times,
                            const std::vector<SeenOutput>& outputs, ForecastComponent& component) {
  Eigen::VectorXd values(component.mean.cols());
  Eigen::MatrixXd by_errors(component.mean.cols(), model.errors());
  for (Eigen::Index row = 0; row < component.mean.rows(); ++row) {
    const double there = times[static_cast<std::size_t>(row)] - filter.lead();
    if (there > here && !filter.predict(ahead, here, there - here)) return row;
    here = std::max(here, there);
    if (!filter.observe(ahead.point, here, outputs, false, values, &by_errors)) return row;
    component.mean.row(row) = values.transpose();
    const Eigen::MatrixXd half = by_errors * ahead.covariance;
    component.covariance[static_cast<std::size_t>(row)].noalias() = half * by_errors.transpose();
  }
  return component.mean.rows();
}

/// What would be seen of a motion from a point. @returns whether it is finite
bool follow_point(HypothesisFilter& filter, Eigen::VectorXd point, double here, std::span<const double> times,
                  const std::vector<SeenOutput>& outputs, Eigen::MatrixXd& seen) {
  Eigen::VectorXd values(seen.cols());
  for (Eigen::Index row = 0; row < seen.rows(); ++row) {
    const double there = times[static_cast<std::size_t>(row)] - filter.lead();
    if (there > here && !filter.move(point, here, there - here)) return false;
    here = std::max(here, there);
    if (!filter.observe(point, here, outputs, false, values, nullptr)) return false;
    seen.row(row) = values.transpose();
  }
  return true;
}

/// Adds what bends, and replaces the covariance of the state by that of motions to either side.
bool to_second_order(const FollowedModel& model, HypothesisFilter& filter, const Hypothesis& now, double here,
                     std::span<const double> times, const std::vector<SeenOutput>& outputs,
                     ForecastComponent& component) {
  const Eigen::MatrixXd root = std::sqrt(kDistance2) * root_of(now.covariance);
  const Eigen::MatrixXd middle = component.mean;
  Eigen::MatrixXd one(middle.rows(), middle.cols()), other = one, mean = middle;
  std::vector<Eigen::MatrixXd> covariances(component.covariance.size(),
                                           Eigen::MatrixXd::Zero(middle.cols(), middle.cols()));
  Eigen::VectorXd point(model.size());
  for (Eigen::Index column = 0; column < root.cols(); ++column) {
    model.plus(now.point, root.col(column), point);
    if (!follow_point(filter, point, here, times, outputs, one)) return false;
    model.plus(now.point, -root.col(column), point);
    if (!follow_point(filter, point, here, times, outputs, other)) return false;
    const Eigen::MatrixXd slope = (one - other) / (2.0 * std::sqrt(kDistance2));
    const Eigen::MatrixXd bend = (one + other - 2.0 * middle) / (2.0 * kDistance2);
    mean += bend;
    for (Eigen::Index row = 0; row < middle.rows(); ++row) {
      covariances[static_cast<std::size_t>(row)] += slope.row(row).transpose() * slope.row(row);
      covariances[static_cast<std::size_t>(row)] +=
          (kDistance2 - 1.0) * bend.row(row).transpose() * bend.row(row);
    }
  }
  component.mean = mean;
  for (std::size_t row = 0; row < covariances.size(); ++row) component.covariance[row] += covariances[row];
  return true;
}

}  // namespace

ForecastComponent forecast_component(const FollowedModel& model, HypothesisFilter& filter,
                                     const Hypothesis& now, double state_time, std::span<const double> times,
                                     const std::vector<SeenOutput>& outputs) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  const auto rows = static_cast<Eigen::Index>(times.size()), width = std::ssize(outputs);
  const auto empty = [&] {
    return ForecastComponent{.weight = std::exp(now.log_weight),
                             .mean = Eigen::MatrixXd::Constant(rows, width, kNothing),
                             .covariance = std::vector<Eigen::MatrixXd>(
                                 times.size(), Eigen::MatrixXd::Constant(width, width, kNothing))};
  };
  ForecastComponent component = empty();
  bool is_second = model.options().forecasts == ForecastOrder::second;
  if (is_second) {
    // What comes in on the way alone; then the rest.
    const Hypothesis exact{.point = now.point,
                           .covariance = Eigen::MatrixXd::Zero(model.errors(), model.errors())};
    is_second = to_first_order(model, filter, exact, state_time, times, outputs, component) == rows &&
                to_second_order(model, filter, now, state_time, times, outputs, component);
  }
  if (!is_second) {
    component = empty();
    to_first_order(model, filter, {.point = now.point, .covariance = now.covariance}, state_time, times,
                   outputs, component);
  }
  for (Eigen::MatrixXd& covariance : component.covariance) {
    for (Eigen::Index o = 0; o < width; ++o)
      covariance(o, o) +=
          outputs[static_cast<std::size_t>(o)].noise * outputs[static_cast<std::size_t>(o)].noise;
  }
  return component;
}

}  // namespace samara::identification
