#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/flow/grid/body_path.h"
#include "samara/flow/grid/borders.h"
#include "samara/flow/grid/openness.h"
#include "samara/flow/grid/shape.h"
#include "samara/flow/march/body_loads.h"
#include "samara/flow/momentum/momentum_step.h"
#include "samara/flow/momentum/projection.h"
#include "samara/flow/turbulence/k_epsilon.h"

/// One step after another of the flow about a body:
///
///   div u = 0,   du/dt + div(u u) = -grad p + div(2 (nu + nu_T) S) + f,   p includes 2k/3
///
/// with k and eps after k_epsilon.h where there is turbulence. All is in units of a length, a speed and a
/// density of the case; nu is then 1/Re.
namespace samara::flow {

struct FlowSetup {
  MacGrid grid;
  Borders borders;
  std::optional<PlacedShape> body = {};
  /// Where the body is at a time; empty: held where it was placed. The openness of faces is measured anew in every
  /// step, and what the body sweeps is a source of the divergence (projection.h).
  BodyPath path = {};
  double viscosity = 0.0;
  Eigen::Vector3d body_force = Eigen::Vector3d::Zero();
  AdvectionScheme scheme = AdvectionScheme::van_leer;
  TurbulenceModel turbulence = TurbulenceModel::none;
  PressureSolverKind pressure = PressureSolverKind::automatic;
  /// Largest share of a cell that flows out of it in a step, all directions together. Up to 0.5 k and eps stay
  /// positive.
  double courant = 0.45;
  /// Guard of nu_T, which k_epsilon.h describes.
  double largest_eddy_viscosity = 0.2;
  /// Largest h div u/U that is left.
  double divergence = 1e-8;
};

/// @param when in the message @throws ArgumentError if a body comes within four cells of a border
void require_within(const MacGrid& grid, const PlacedShape& body, const std::string& when);

/// What a step says of itself.
struct StepReport {
  double step = 0.0;
  PressureSolve pressure;
  bool finite = true;
};

class FlowMarch {
 public:
  /// @throws ArgumentError if the borders do not fit together, the body is thinner than two cells or reaches a
  /// border, or a number is not positive.
  explicit FlowMarch(FlowSetup setup);

  /// Velocity at the start by place, component by component at the centres of its faces; then made free of divergence.
  /// @throws ArgumentError if it is not finite at one of them
  void set_velocity(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& velocity);
  void set_turbulence(double k, double epsilon);

  /// The longest step that the velocity allows now, and the body's, which shall not move by more than half a cell in
  /// it.
  double allowed_step();
  /// @param step where more than half a cell flows out in it, parallel streams become unstable
  /// @throws ArgumentError if the body's path is not finite, leaps, or comes to a border
  StepReport advance(double step);
  StepReport advance() { return advance(allowed_step()); }

  /// Where the body is, of a state that was set from elsewhere (flow_checkpoint.h).
  void find_body();

  const FlowSetup& setup() const { return setup_; }
  const MacGrid& grid() const { return setup_.grid; }
  const Openness& openness() const { return open_; }
  FlowState& state() { return state_; }
  const FlowState& state() const { return state_; }
  bool moves() const { return static_cast<bool>(setup_.path); }
  const BodyPose& pose() const { return pose_; }
  KEpsilon* turbulence() { return turbulence_.get(); }
  const KEpsilon* turbulence() const { return turbulence_.get(); }

  /// Of the last step.
  BodyLoads loads() const;
  Eigen::Vector3d force_by_box(int margin_cells) const;
  /// Largest |h div u| now.
  double divergence() { return projection_.divergence(state_); }

  // Parts that point at one another.
  FlowMarch(const FlowMarch&) = delete;
  FlowMarch& operator=(const FlowMarch&) = delete;

 private:
  void move_body(double time);
  void fill_fresh_cells(Field& field) const;
  void set_closed_faces();

  FlowSetup setup_;
  BodyPose pose_;
  std::vector<Index> were_closed_;  ///< cells, before the last move
  Openness open_;
  std::optional<VolumesBefore> volumes_before_;  ///< of a body that moves
  std::vector<FaceForce> reshaping_;             ///< of the last step
  MomentumStep momentum_;
  Projection projection_;
  FlowState state_;
  std::unique_ptr<KEpsilon> turbulence_;
  RowSums sums_;
};

}  // namespace samara::flow
