#include "samara/codebooks/source/model_measure.h"

#include <algorithm>
#include <span>

#include "samara/models/integrators/integrate.h"

namespace samara::codebooks {

Eigen::VectorXd floors_of(const std::map<std::string, double>& absolute,
                          const std::vector<pgd::OutputLabel>& outputs) {
  Eigen::VectorXd floors = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(outputs.size()));
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const auto floor = absolute.find(outputs[o].name);
    if (floor != absolute.end()) floors[static_cast<Eigen::Index>(o)] = floor->second;
  }
  return floors;
}

Eigen::VectorXd state_sizes(const models::ParametricModel& model, const Eigen::VectorXd& q) {
  const models::Scales scales = model.scales({q.data(), static_cast<std::size_t>(q.size())});
  Eigen::VectorXd sizes = Eigen::VectorXd::Zero(model.state_count());
  for (Eigen::Index s = 0; s < sizes.size(); ++s) {
    const models::StateInfo& state = model.model().info().states[static_cast<std::size_t>(s)];
    if (models::has_scale(state)) sizes[s] = models::state_scale(state, scales);
  }
  return sizes;
}

double share_for_range(const models::ParametricModel& model, const Eigen::MatrixXd& points, double end,
                       const pgd::OutputMeasure& measure) {
  constexpr int kTimes = 32;
  constexpr double kOffset = 0.1;
  std::vector<double> times;
  for (int i = 0; i <= kTimes; ++i) times.push_back(end * i / kTimes);
  models::Integrator integrator(model, {}, false);
  Eigen::VectorXd smallest, largest;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const models::Trajectory found =
        integrator({points.col(j).data(), static_cast<std::size_t>(points.rows())}, times);
    if (!found.is_usable()) continue;
    const Eigen::VectorXd low = found.states.colwise().minCoeff(), high = found.states.colwise().maxCoeff();
    smallest = smallest.size() == 0 ? low : smallest.cwiseMin(low).eval();
    largest = largest.size() == 0 ? high : largest.cwiseMax(high).eval();
  }
  if (smallest.size() == 0) return 1.0;
  const Eigen::VectorXd scales = pgd::error_scales(smallest, largest, measure);
  const double share =
      scales.cwiseQuotient(smallest.cwiseAbs().cwiseMax(largest.cwiseAbs()).cwiseMax(scales)).minCoeff();
  return share < kOffset ? share : 1.0;
}

}  // namespace samara::codebooks
