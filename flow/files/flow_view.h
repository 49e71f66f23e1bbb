#pragma once

#include <memory>

#include "samara/flow/files/flow_file.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/stochastic/turbulent_flow.h"

namespace samara::flow {

/// A flow of a file in the world of the models: how large, how fast, and where.
struct FlowPlacement {
  double speed = 1.0;   ///< U [m/s]
  double length = 1.0;  ///< l [m]
  /// Where the centre of the flow's own body is, world axes [m].
  Eigen::Vector3d body = Eigen::Vector3d::Zero();
  /// Beyond the grid the stream goes on with the energy with which it flows in; else the flow ends there.
  bool stream_beyond = false;
};

/// The mean flow and the energy of a flow file as what models fly in. The stream runs along world x, the flow's y is
/// world z, up; a flow in the plane is the same for all world y.
///
/// Between cells all is the quadratic B-spline of the values in their centres, which smooths by h^2/8 of the second
/// derivative, as the solver's own error is: k and epsilon stay positive, and gradients are continuous and exact.
/// Beyond the grid there is the stream at the inflow; with its energy, which is the same everywhere, or with none and
/// not `inside`, as the placement says.
class FlowView final : public models::TurbulentFlow {
 public:
  /// @throws ArgumentError if speed or length is not positive and finite, the place not finite, the flow that of a body
  /// that moves, or the stream is to go on and the file does not say its intensity
  FlowView(std::shared_ptr<const StoredFlow> flow, const FlowPlacement& placement);

  models::AmbientSample sample(double t, const Eigen::Vector3d& position) const override;
  /// Two cells.
  double length() const override;
  /// k is the modelled and the resolved one; a laminar flow has none. Not `inside` beyond the grid, where the flow
  /// ends.
  models::Turbulence turbulence(double t, const Eigen::Vector3d& position) const override;
  /// Whether the grid holds the point, a cell at its borders left out.
  bool inside(const Eigen::Vector3d& position) const;
  /// Whether the point lies in a cell that the flow's own body fills by more than half.
  bool in_body(const Eigen::Vector3d& position) const;

 private:
  struct Value;
  Value value_of(const Field& field, const Eigen::Vector3d& position) const;
  /// In cells from the centre of the first.
  Eigen::Vector3d in_cells(const Eigen::Vector3d& position) const;

  std::shared_ptr<const StoredFlow> flow_;
  FlowPlacement placement_;
  const Field* velocity_[3] = {};  ///< along the flow's axes; null: none
  const Field* k_ = nullptr;
  const Field* epsilon_ = nullptr;  ///< null of a laminar flow
  Field open_k_, open_epsilon_;     ///< 0 in closed cells
  models::Turbulence beyond_;       ///< of what is beyond the grid
};

/// Of a motion that begins with no coordinate free. @throws ArgumentError if that is within the flow's own body
void check_release(const FlowView& view, const models::ParametricModel& model);

}  // namespace samara::flow
