#pragma once

#include <array>
#include <vector>

#include "samara/flow/grid/borders.h"
#include "samara/flow/grid/openness.h"
#include "samara/flow/grid/rows.h"
#include "samara/flow/grid/turbulence_model.h"
#include "samara/flow/momentum/momentum_step.h"
#include "samara/flow/turbulence/monotone_transport.h"
#include "samara/flow/turbulence/wall_law.h"

/// The k-epsilon model at high Reynolds number (W. Jones, B. Launder, Int. J. Heat Mass Transfer 15 (1972) 301;
/// constants of Launder and Spalding 1974), with the law of the wall:
///
///   dk/dt   + div(u k)   = div((nu + nu_T/s_k) grad k)   + G - eps
///   deps/dt + div(u eps) = div((nu + nu_T/s_e) grad eps) + (eps/k)(C_1 G - C_2 eps),   nu_T = C_mu k^2/eps
///   G = nu_T |S|^2, or nu_T |S| |W| (M. Kato, B. Launder 1993): less of it where a flow stagnates;
///   |S|^2 = 2 S:S, |W|^2 = 2 W:W
///
/// Each part is solved so that it keeps k and eps positive: transport within bounds (monotone_transport.h),
/// production and decay are exact, one between two halves of the other: homogeneous turbulence is of second
/// order in the step. Nothing is clipped; the guard nu_T <= `largest_eddy_viscosity` counts where it acts,
/// and a developed flow must not need it.
namespace samara::flow {

/// Of a stream of intensity I = u'/U whose eddies are 7 % of a length: k = 1.5 (I U)^2, eps = C_mu^{3/4}
/// k^{3/2}/(0.07 l).
std::array<double, 2> stream_turbulence(double intensity, double speed, double length);

/// What happened to the sum of V k in a step [h^dimensions U^2].
struct EnergyBudget {
  double entered = 0.0, produced = 0.0, dissipated = 0.0;
  double before = 0.0, after = 0.0;
  /// What is stored less what came, over the largest of them.
  double defect() const;
};

class KEpsilon {
 public:
  /// @param grid, borders, open must outlive this object
  KEpsilon(const MacGrid& grid, const Borders& borders, const Openness& open, double viscosity,
           TurbulenceModel model, double largest_eddy_viscosity);

  /// After the body has moved, and `open` with it. @param pose at the end of the step that follows
  void follow_body(const BodyPose& pose);
  /// Both everywhere.
  void set(double k, double epsilon);
  /// nu_T, G and what the walls take, from the fields as they are. @param velocity with filled margins
  void prepare(const FaceField& velocity);
  /// k and eps one step on, carried by the new velocity.
  void advance(const FaceField& velocity, double step);

  const Field& eddy_viscosity() const { return eddy_; }
  const WallConductance& conductance() const { return conductance_; }
  Field k, epsilon;

  const EnergyBudget& budget() const { return budget_; }
  /// Cells where k or eps was not positive in the last step, when it was carried there or at the end:
  /// never, if the step kept to its limit.
  long not_positive() const { return not_positive_; }
  /// Cells where the guard of nu_T acts.
  long guarded() const { return guarded_; }
  /// Least and largest y+ of cells beside walls, and the share of those in the viscous layer.
  std::array<double, 3> wall_range() const;
  /// Integral of G over the domain [U^3 l^(dimensions - 1)].
  double total_production();

 private:
  void set_walls();
  void find_production(const FaceField& velocity);
  void apply_wall_law(const FaceField& velocity);
  static constexpr Index kTogether = 128;  ///< cells of a row whose sources act at once
  /// Over the cells of a row, in lanes.
  struct Sums {
    double produced[kEight] = {}, dissipated[kEight] = {}, not_positive[kEight] = {};
  };
  void act_in_fluid(Index first, Index end, double step, Sums& sums);
  void act_beside_wall(Index c, double step, Sums& sums);
  void apply_sources(double step);
  double total(const Field& of);

  const MacGrid& grid_;
  const Borders& borders_;
  const Openness& open_;
  double viscosity_;
  TurbulenceModel model_;
  double largest_eddy_viscosity_;
  MonotoneTransport transport_;
  Field eddy_, production_;
  Field straining_;      ///< C_mu |S|^2 or C_mu |S| |W|
  Field wall_distance_;  ///< of cells beside walls; 0 elsewhere
  WallConductance conductance_;
  BodyPose pose_;  ///< at rest of held bodies
  std::array<double, 6> given_k_, given_epsilon_, wall_eddy_;
  double returning_k_ = 0.0, returning_epsilon_ = 0.0;  ///< carried by what comes back through an outflow
  EnergyBudget budget_;
  long not_positive_ = 0, guarded_ = 0;
  std::vector<std::array<double, 3>> row_sums_;  ///< produced, dissipated, not positive, by rows
  RowSums sums_;
};

}  // namespace samara::flow
