#include "samara/motion/sweeps/lyapunov_exponents.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "samara/models/batch/batch.h"

namespace samara::motion {

namespace {

/// The plan's model with what is disturbed free as well, and where it stands among the coordinates.
struct Disturbed {
  models::ParametricModel model;
  std::vector<std::string> tangents;
  Eigen::MatrixXd points;
};

Disturbed disturbed(const SweepPlan& plan, const Eigen::MatrixXd& points) {
  const models::ModelInfo& info = plan.model->info();
  std::vector<std::string> tangents = {"theta(0)"};
  if (!MotionStates(info).is_planar()) tangents = {"wx(0)", "wy(0)"};
  const models::ParametricModel usual = plan.parametric_model();
  std::vector<std::string> free;
  for (const auto& coordinate : usual.free()) free.push_back(coordinate.name);
  std::map<std::string, double> fixed = plan.fixed;
  Eigen::MatrixXd all = points;
  for (const std::string& name : tangents) {
    if (std::ranges::find(free, name) != free.end()) continue;
    double value = 0.0;
    for (const auto& state : info.states) {
      if (state.name + "(0)" == name) value = models::held_start(state, fixed);
    }
    fixed.erase(name);
    free.push_back(name);
    all.conservativeResize(Eigen::NoChange, all.cols() + 1);
    all.col(all.cols() - 1).setConstant(value);
  }
  return {models::ParametricModel(plan.model, fixed, free), tangents, std::move(all)};
}

/// 1/scale of each state of a fall, 0 of a place.
Eigen::VectorXd weights_of(const models::ParametricModel& model, const Eigen::VectorXd& q) {
  const models::ModelInfo& info = model.model().info();
  const models::Scales scales = model.scales({q.data(), static_cast<std::size_t>(q.size())});
  Eigen::VectorXd weights(static_cast<Eigen::Index>(info.states.size()));
  for (std::size_t i = 0; i < info.states.size(); ++i) {
    const std::string& name = info.states[i].name;
    const bool place = name == "x" || name == "y" || name == "z";
    weights[static_cast<Eigen::Index>(i)] = place ? 0.0 : 1.0 / models::state_scale(info.states[i], scales);
  }
  return weights;
}

}  // namespace

Eigen::VectorXd lyapunov_exponents(const SweepPlan& plan, const Eigen::MatrixXd& points, Eigen::Index first,
                                   int threads, const ProgressCallback& progress) {
  const Disturbed all = disturbed(plan, points);
  // From a settling time of 0 the tangent still is what it was made.
  const double from = std::max(plan.settle, 0.05 * plan.until);
  const std::array times = {from, plan.until};
  const models::BatchTrajectories batch = integrate_batch(
      all.model, all.points, times,
      {.step = plan.step, .threads = threads, .tangents = all.tangents, .progress = progress});
  Eigen::VectorXd exponents(points.rows());
  for (Eigen::Index n = 0; n < points.rows(); ++n) {
    const Eigen::VectorXd weights = weights_of(all.model, all.points.row(n));
    const auto size = [&](Eigen::Index k) {
      Eigen::VectorXd tangent = batch.tangents[0].col(batch.column(n, k));
      if (batch.tangents.size() > 1) {
        const double axis =
            plan.releases.empty()
                ? 0.0
                : plan.releases[static_cast<std::size_t>(first + n) % plan.releases.size()].axis;
        // Exactly in the plane of the release, where there is one.
        const double c = std::cos(axis), s = std::sin(axis);
        tangent *= std::abs(c) < 1e-15 ? 0.0 : c;
        if (std::abs(s) >= 1e-15) tangent += s * batch.tangents[1].col(batch.column(n, k));
      }
      return tangent.cwiseProduct(weights).norm();
    };
    const double growth = std::log(size(1) / size(0)) / (plan.until - from);
    exponents[n] = std::isfinite(growth) ? growth : std::numeric_limits<double>::quiet_NaN();
  }
  return exponents;
}

}  // namespace samara::motion
