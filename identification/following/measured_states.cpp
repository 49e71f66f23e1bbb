#include "samara/identification/following/measured_states.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>

namespace samara::identification {

MeasuredStates measured_states(const FollowedModel& model, std::span<const SeenFrame> frames) {
  MeasuredStates result;
  for (Eigen::VectorXd* vector : {&result.values, &result.rates, &result.rate_errors})
    vector->setConstant(model.states(), std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index row = 0; row < std::ssize(model.measured()); ++row) {
    const SeenOutput& output = model.measured()[static_cast<std::size_t>(row)];
    if (!output.is_state) continue;
    std::vector<double> times, values;
    double last = std::numeric_limits<double>::quiet_NaN();
    for (const SeenFrame& frame : frames) {
      double value = frame.values[row];
      if (std::isnan(value)) continue;
      // Angles go on from the frame before.
      if (output.period > 0.0 && !values.empty()) value = last + std::remainder(value - last, output.period);
      times.push_back(frame.time - frames.front().time);
      values.push_back(last = value);
    }
    if (values.empty()) continue;
    const Eigen::Index count = std::ssize(values);
    const Eigen::Index degree = count >= 5 ? 2 : std::min<Eigen::Index>(count - 1, 1);
    const double span = degree > 0 ? times.back() : 1.0;  // times are scaled by it
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(degree + 1, degree + 1);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(degree + 1);
    for (std::size_t k = 0; k < values.size(); ++k) {
      Eigen::VectorXd powers = Eigen::VectorXd::Ones(degree + 1);
      for (Eigen::Index power = 1; power <= degree; ++power)
        powers[power] = powers[power - 1] * times[k] / span;
      normal += powers * powers.transpose();
      right += values[k] * powers;
    }
    const Eigen::LLT<Eigen::MatrixXd> llt(normal);
    const Eigen::VectorXd fitted = llt.solve(right);
    result.values[output.index] = fitted[0];
    if (degree == 0) continue;
    const Eigen::VectorXd spread = llt.solve(Eigen::VectorXd::Unit(degree + 1, 1));
    result.rates[output.index] = fitted[1] / span;
    result.rate_errors[output.index] = output.noise * std::sqrt(spread[1]) / span;
  }
  return result;
}

}  // namespace samara::identification
