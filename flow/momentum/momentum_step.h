#pragma once

#include <array>
#include <vector>

#include "samara/flow/grid/body_path.h"
#include "samara/flow/grid/borders.h"
#include "samara/flow/grid/openness.h"
#include "samara/flow/momentum/momentum_flux.h"

namespace samara::flow {

/// Velocity and pressure, and what the next step needs of the last one.
struct FlowState {
  double time = 0.0;
  long steps = 0;
  double last_step = 0.0;  ///< its length; 0: there was none
  FaceField u, u_before;   ///< now, and a step before
  Field p;                 ///< half a step before `time`
  Field p_change;          ///< of the last step, from which the next solve starts

  explicit FlowState(const MacGrid& grid);
};

/// Momentum that walls take: per open face beside a wall, in the order of Openness::wall_faces, force over velocity and
/// volume [U/l]: area/h nu/distance, or by the law of the wall.
using WallConductance = std::array<std::vector<double>, 3>;

/// What a step computes beside the velocity, for the balances.
struct StepRecord {
  /// Of component d after the lines along j: half-implicit increments; the last is that of the predicted velocity.
  std::array<FaceField, 3> increment;
};

/// The first half of a step of the projection method, incremental in the pressure (K. Goda; J. van Kan, SIAM J. Sci.
/// Stat. Comput. 7 (1986) 870), for the control volumes of openness.h:
///
///   V du/dt = - sum of fluxes - a grad p - losses to walls
///
/// Beside a body that moves, what flows into a control volume is not what flows out: the body sweeps the rest.
/// There V du/dt gains u times that difference, so that a uniform velocity stays uniform, and walls take
/// momentum by the velocity relative to them.
///
/// Advection takes the velocity extrapolated to the middle of the step (Adams-Bashforth), diffusion is
/// Crank-Nicolson in directional factors, walls take momentum implicitly. Second order in time where
/// no wall is seen through conductances.
class MomentumStep {
 public:
  /// @param grid, borders, open must outlive this object
  MomentumStep(const MacGrid& grid, const Borders& borders, const Openness& open, AdvectionScheme scheme,
               double viscosity, const Eigen::Vector3d& body_force = Eigen::Vector3d::Zero());

  /// u := u*, before the pressure makes it free of divergence. Margins of state.u must be filled; those of u* are not.
  /// @param eddy nu_T of cells with filled margins; null: laminar
  /// @param conductance of the walls; null: molecular viscosity over the distance
  void predict(FlowState& state, double step, const Field* eddy, const WallConductance* conductance);

  /// After the body has moved, and `open` with it. @param pose at the end of the step that follows
  void follow_body(const BodyPose& pose);

  /// Flux through the lower face across j of the control volume of face (d, c) that the last step took, implicit parts
  /// included [U^2 per area].
  double flux_taken(const FlowState& state, int d, int j, Index c) const;
  /// Volume that flowed into the control volume of a face in the last step, per area [U]: 0, but beside a body that
  /// moves.
  double volume_taken(int d, Index c) const;
  /// u_d that was carried in the last step, extrapolated to its middle.
  double carried(int d, Index c) const {
    return extrapolated_[static_cast<std::size_t>(d)][static_cast<std::size_t>(c)];
  }
  /// Momentum that the wall at a face took, per volume.
  double wall_loss_taken(const FlowState& state, int d, std::size_t piece) const;

  /// Faces whose velocity is solved for.
  Range unknown_faces(int d) const;

 private:
  void set_walls();
  void set_sweeping();
  void extrapolate(const FlowState& state, double step);
  FluxInput flux_input(const Field& u, int d, int j) const;
  void add_explicit(const FlowState& state, int d, double step);
  void solve_implicit(int d, double step);
  void carry_out(FlowState& state, double step) const;

  const MacGrid& grid_;
  const Borders& borders_;
  const Openness& open_;
  AdvectionScheme scheme_;
  double viscosity_;
  Eigen::Vector3d body_force_;
  WallConductance molecular_;
  std::array<std::vector<double>, 3> wall_velocity_;  ///< u_d of the walls' pieces
  bool sweeps_ = false;                               ///< the body moves
  FaceField sweeping_;                                ///< what that adds to the rates; empty of held bodies
  const Field* eddy_ = nullptr;
  const WallConductance* conductance_ = nullptr;
  FaceField extrapolated_, discharge_, loss_;
  StepRecord record_;
  Field ratio_, turn_;  ///< of the eliminations
};

}  // namespace samara::flow
