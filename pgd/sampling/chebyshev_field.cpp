#include "samara/pgd/sampling/chebyshev_field.h"

#include <algorithm>
#include <utility>

#include "samara/pgd/axes/lagrange.h"
#include "samara/pgd/sampling/leja.h"

namespace samara::pgd {

namespace {

/// The core's values at other nodes [the coordinate's unit], interpolated from the Leja nodes.
TrainCore at_nodes(const TrainCore& core, const Eigen::VectorXd& nodes, const CoordinateMap& map) {
  const LagrangeBasis basis(leja_points(core.size));
  TrainCore moved(core.left, core.size, core.right);
  Eigen::VectorXd weights(core.size);
  for (int i = 0; i < core.size; ++i) {
    // The ends are nodes of both.
    basis.values(std::clamp(map.to_unit(nodes[i]), -1.0, 1.0), weights);
    for (int r = 0; r < core.right; ++r) {
      const Eigen::Index column = Eigen::Index{core.size} * r;
      auto target = moved.data.segment(core.left * (i + column), core.left);
      for (int j = 0; j < core.size; ++j) {
        target += weights[j] * core.data.segment(core.left * (j + column), core.left);
      }
    }
  }
  return moved;
}

}  // namespace

TrainField on_chebyshev_axes(const std::vector<SampledCoordinate>& coordinates,
                             const std::vector<CoordinateMap>& maps, const std::vector<OutputLabel>& outputs,
                             TensorTrain train) {
  std::vector<Axis> axes;
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    const SampledCoordinate& c = coordinates[k];
    TrainCore& core = train.cores[k + 1];
    Axis::Label label = c.label;
    label.transform = maps[k].transform();
    axes.push_back(Axis::chebyshev(label, c.lower, c.upper, core.size));
    core = at_nodes(core, axes[k].nodes(), maps[k]);
  }
  return {std::move(axes), outputs, std::move(train)};
}

}  // namespace samara::pgd
