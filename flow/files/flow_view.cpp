#include "samara/flow/files/flow_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/flow/turbulence/k_epsilon.h"
#include "samara/models/stochastic/gust_layout.h"

namespace samara::flow {

namespace {

/// World axis of an axis of the flow, and its sign: y is up, and z completes a right-handed frame.
constexpr int kWorldAxis[3] = {0, 2, 1};
constexpr double kWorldSign[3] = {1.0, 1.0, -1.0};

/// Quadratic B-spline about the nearest centre: weights of it and its two neighbours, and their slopes.
struct Spline {
  int nearest = 0;
  double weight[3] = {0.0, 1.0, 0.0};
  double slope[3] = {};

  Spline() = default;
  explicit Spline(double place) : nearest(static_cast<int>(std::floor(place + 0.5))) {
    const double offset = place - nearest;
    weight[0] = 0.5 * (0.5 - offset) * (0.5 - offset);
    weight[1] = 0.75 - offset * offset;
    weight[2] = 0.5 * (0.5 + offset) * (0.5 + offset);
    slope[0] = offset - 0.5;
    slope[1] = -2.0 * offset;
    slope[2] = offset + 0.5;
  }
};

Field where_open(const Field& field, const Field& open) {
  Field kept = field;
  for (std::size_t c = 0; c < kept.size(); ++c) {
    if (open[c] == 0.0) kept[c] = 0.0;
  }
  return kept;
}

}  // namespace

/// A value and its gradient, per cell along the flow's axes.
struct FlowView::Value {
  double value = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

FlowView::FlowView(std::shared_ptr<const StoredFlow> flow, const FlowPlacement& placement)
    : flow_(std::move(flow)), placement_(placement) {
  require_positive(placement.speed, "speed", "FlowView");
  require_positive(placement.length, "length", "FlowView");
  if (!placement.body.allFinite()) throw ArgumentError("FlowView: the place of the body is not finite");
  if (flow_->summary.moving)
    throw ArgumentError(
        "FlowView: the flow is that of a body that moves, and holds one instant: expected the mean flow of a "
        "held one");
  constexpr const char* kNames[3] = {"u", "v", "w"};
  for (int d = 0; d < flow_->grid.dimensions; ++d) velocity_[d] = &flow_->field(kNames[d]).values;
  open_k_ = where_open(flow_->field("k").values, flow_->open);
  k_ = &open_k_;
  const auto has_epsilon = [](const CentreField& field) { return field.name == "epsilon"; };
  if (std::any_of(flow_->fields.begin(), flow_->fields.end(), has_epsilon)) {
    open_epsilon_ = where_open(flow_->field("epsilon").values, flow_->open);
    epsilon_ = &open_epsilon_;
  }
  beyond_.inside = placement.stream_beyond;
  if (!placement.stream_beyond || epsilon_ == nullptr) return;
  if (!flow_->summary.intensity)
    throw ArgumentError(
        "FlowView: the stream is to go on beyond the grid, and the file does not say its intensity: expected "
        "one "
        "that was solved by this version");
  const std::array<double, 2> stream =
      stream_turbulence(*flow_->summary.intensity, placement.speed, placement.length);
  beyond_.k = stream[0];
  beyond_.epsilon = stream[1];
}

Eigen::Vector3d FlowView::in_cells(const Eigen::Vector3d& position) const {
  const MacGrid& grid = flow_->grid;
  Eigen::Vector3d cells = Eigen::Vector3d::Zero();
  for (int d = 0; d < grid.dimensions; ++d) {
    const double along =
        kWorldSign[d] * (position(kWorldAxis[d]) - placement_.body(kWorldAxis[d])) / placement_.length;
    cells(d) = (along - grid.origin(d)) / grid.spacing - 0.5;
  }
  return cells;
}

bool FlowView::inside(const Eigen::Vector3d& position) const {
  const Eigen::Vector3d cells = in_cells(position);
  for (int d = 0; d < flow_->grid.dimensions; ++d) {
    // The spline takes a cell on each side.
    if (!(cells(d) >= 0.5) || !(cells(d) < flow_->grid.cells[static_cast<std::size_t>(d)] - 1.5))
      return false;
  }
  return true;
}

bool FlowView::in_body(const Eigen::Vector3d& position) const {
  if (!inside(position)) return false;
  const Eigen::Vector3d cells = in_cells(position);
  std::array<int, 3> nearest{};
  for (int d = 0; d < flow_->grid.dimensions; ++d)
    nearest[static_cast<std::size_t>(d)] = Spline(cells(d)).nearest;
  const auto at = flow_->grid.at(nearest[0], nearest[1], nearest[2]);
  return flow_->open[static_cast<std::size_t>(at)] < 0.5;
}

FlowView::Value FlowView::value_of(const Field& field, const Eigen::Vector3d& position) const {
  const MacGrid& grid = flow_->grid;
  const Eigen::Vector3d cells = in_cells(position);
  Spline spline[3];
  for (int d = 0; d < grid.dimensions; ++d) spline[d] = Spline(cells(d));
  const int layers = grid.dimensions == 3 ? 1 : 0;
  Value sum;
  for (int k = -layers; k <= layers; ++k) {
    for (int j = -1; j <= 1; ++j) {
      for (int i = -1; i <= 1; ++i) {
        const double value = field[static_cast<std::size_t>(
            grid.at(spline[0].nearest + i, spline[1].nearest + j, spline[2].nearest + k))];
        const double x = spline[0].weight[i + 1], y = spline[1].weight[j + 1], z = spline[2].weight[k + 1];
        sum.value += x * y * z * value;
        sum.gradient +=
            value * Eigen::Vector3d(spline[0].slope[i + 1] * y * z, x * spline[1].slope[j + 1] * z,
                                    x * y * spline[2].slope[k + 1]);
      }
    }
  }
  return sum;
}

models::AmbientSample FlowView::sample(double, const Eigen::Vector3d& position) const {
  models::AmbientSample sample;
  if (!inside(position)) {
    sample.velocity.x() = placement_.speed;
    return sample;
  }
  const double per_metre = 1.0 / (flow_->grid.spacing * placement_.length);
  for (int d = 0; d < flow_->grid.dimensions; ++d) {
    const Value value = value_of(*velocity_[d], position);
    const double scale = kWorldSign[d] * placement_.speed;
    sample.velocity(kWorldAxis[d]) = scale * value.value;
    for (int j = 0; j < flow_->grid.dimensions; ++j)
      sample.gradient(kWorldAxis[d], kWorldAxis[j]) = scale * kWorldSign[j] * per_metre * value.gradient(j);
  }
  return sample;
}

double FlowView::length() const {
  return 2.0 * flow_->grid.spacing * placement_.length;
}

models::Turbulence FlowView::turbulence(double, const Eigen::Vector3d& position) const {
  if (!inside(position)) return beyond_;
  models::Turbulence energy;
  if (epsilon_ == nullptr) return energy;
  const Value k = value_of(*k_, position);
  const double speed = placement_.speed;
  energy.k = speed * speed * k.value;
  energy.epsilon = speed * speed * speed / placement_.length * value_of(*epsilon_, position).value;
  if (energy.k == 0.0) return energy;
  // d sigma = d k/(3 sigma)
  const double sigma = std::sqrt(2.0 * energy.k / 3.0);
  const double scale = speed * speed / (flow_->grid.spacing * placement_.length) / (3.0 * sigma);
  for (int d = 0; d < flow_->grid.dimensions; ++d)
    energy.sigma_gradient(kWorldAxis[d]) = kWorldSign[d] * scale * k.gradient(d);
  return energy;
}

void check_release(const FlowView& view, const models::ParametricModel& model) {
  std::vector<double> start(static_cast<std::size_t>(model.state_count()));
  model.initial({}, start);
  models::BodyOnPath motion;
  models::GustLayout(model.model()).read([&](int i) { return start[static_cast<std::size_t>(i)]; }, motion);
  const Eigen::Vector3d& p = motion.position;
  if (view.in_body(p)) {
    throw ArgumentError(fmt::format(
        "the motion begins at ({:.6g}, {:.6g}, {:.6g}) m, within the body of the flow; a place in its fluid "
        "was expected",
        p.x(), p.y(), p.z()));
  }
}

}  // namespace samara::flow
