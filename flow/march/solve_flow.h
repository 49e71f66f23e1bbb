#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "samara/base/progress.h"
#include "samara/flow/grid/mac_grid.h"
#include "samara/flow/grid/openness.h"
#include "samara/flow/march/flow_case.h"
#include "samara/flow/march/load_history.h"

/// The flow about a body that is held in a stream: a steady one, or the mean of an unsteady one; or about a body that
/// moves.
///
///   const FlowResult flow = solve_flow({.shape = rectangle_section(1, 1), .reynolds = 22000});
///   flow.drag.value;      // C_D, with flow.drag.half_width
///   flow.k_resolved;      // of what sheds; beside k_modelled
///
/// Square cylinders come out with C_D 20 % low and a bubble twice too long: that is the model (docs/flow.md).
namespace samara::flow {

enum class FlowEnd {
  mean,    ///< of whole periods, once the drag has settled, until its mean is known to 1 % (95 %)
  steady,  ///< when nothing changes any more
  time,    ///< at max_time: of bodies that move
};

enum class FlowStatus {
  steady,    ///< nothing changes: max |du/dt| l/U^2, |dk/dt| l/U^3 < 1e-4
  averaged,  ///< the mean is known
  max_time,  ///< neither was reached by then; fields are means over what was averaged, or one instant without that
  ended,     ///< max_time, which was asked for, and just then: fields are those of that instant
  diverged,  ///< a value is not finite, or k or eps not positive: no fields
  cancelled,
};

/// "steady", "averaged", "max_time", "ended", "diverged", "cancelled"
std::string to_string(FlowStatus status);

struct FlowOptions {
  FlowEnd end = FlowEnd::mean;
  double max_time = 200.0;  ///< l/U
  int threads = 0;          ///< 0: all cores; the result does not depend on it
  std::uint64_t seed = 1;   ///< of the kick behind the body, without which symmetric bodies shed late
  ProgressCallback progress = {};
  /// State of the solver every minute, and at max_time, from where a longer run goes on; empty: none.
  std::filesystem::path checkpoint = {};
  bool resume = false;  ///< from the checkpoint, if it is there, to the same bits
  /// Told in one sentence, once, if the checkpoint cannot be written.
  std::function<void(const std::string&)> warning = {};
  double max_memory = 2e9;  ///< bytes
};

/// What the run says of its own quality.
struct FlowChecks {
  double divergence = 0.0;          ///< largest |h div u|/U after the last step
  double force_disagreement = 0.0;  ///< largest difference of the forces by surface and by box, over the drag
  long unconverged = 0;             ///< steps whose pressure was not found to 1e-8
  double energy_defect = 0.0;       ///< of the budget of k in the last step
  /// Of all steps, where k or eps was carried to 0 or below and a solver that clips would have cut it. Here it ends
  /// the run as `diverged`, and then this is not 0.
  long clipped_cells = 0;
  long guarded_cells = 0;   ///< where the guard of nu_T acted in the last step
  double production = 0.0;  ///< integral of G after the last step
  double y_plus_low = 0.0, y_plus_high = 0.0;
  double viscous_share = 0.0;  ///< of the wall's cells with y+ < 11.5
  double blockage = 0.0;
};

struct FlowResult {
  FlowResult() : grid(2, {1, 1, 1}, 1.0, Eigen::Vector3d::Zero()), body(grid) {}

  MacGrid grid;
  Openness body;
  FaceField velocity;                     ///< means, on faces [U]
  Field pressure;                         ///< [density U^2]; 0 at the outflow
  Field k_modelled, k_resolved, epsilon;  ///< [U^2], [U^3/l]; the first and last are empty without a model
  /// Of known error (half_width finite) if the flow is steady or at least two periods were averaged. At
  /// FlowEnd::time loads are over the whole periods of the motion that fit into the second half of the run, at least
  /// one, and without a period over that half.
  MeanWithError drag;
  double lift = 0.0, moment = 0.0;        ///< means
  double drag_rms = 0.0, lift_rms = 0.0;  ///< deviations; NaN where not even a period was averaged
  /// f l/U; 0: nothing sheds; NaN: not known, of a mean that was not reached or a body that moves.
  double strouhal = 0.0;
  /// Behind the body's centre, where the mean u on the axis turns downstream; without a bubble the
  /// body's rear [l]. 0 of a body that moves.
  double bubble_end = 0.0;
  double averaged_time = 0.0;  ///< l/U
  FlowStatus status = FlowStatus::cancelled;
  std::string message = "solve_flow was not called";
  std::vector<std::string> warnings;
  std::vector<LoadRecord> history;
  FlowChecks checks;
  double time = 0.0;
  long steps = 0;
};

/// A path that ends a run after hours is refused before it. The march looks at it again, step by step.
/// @throws ArgumentError for another end than FlowEnd::time, or a path that is not finite, leaps or comes to a border
/// before max_time; expects a case with a motion that check_case() lets pass
void check_path(const FlowCase& flow, const FlowOptions& options);

/// @throws ArgumentError as check_case() does, for fewer than 0 threads, a checkpoint that stands at max_time
/// already, a body that moves and another end than FlowEnd::time, or a path that is not finite, leaps or comes to a
/// border before max_time; InputError for a checkpoint of another case or version, and, before
/// the march, for another file in its place
FlowResult solve_flow(const FlowCase& flow, const FlowOptions& options = {});

}  // namespace samara::flow
