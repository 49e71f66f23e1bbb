#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/progress.h"
#include "samara/base/termination.h"
#include "samara/pgd/fields/train_field.h"

/// Sampling: a train of fields for a function that can only be called, with few calls and a check that does
/// not believe itself.
///
/// Functional cross interpolation. Every coordinate carries a nested (Leja) grid of a few nodes; the function
/// is interpolated on crosses of that grid, one matrix of pivots between every two neighbouring coordinates,
/// outputs first, so that a call gives all outputs. In every round
///
///  1. pivots are added where the cross errs, found in a random column and the row of its largest error,
///  until
///     none errs by more than the tolerance asks for;
///  2. a few random points of the box, which the builder did not choose and which lie on no grid, are called:
///     the worst of them become pivots too, since a search among neighbours of known pivots cannot see what
///     is orthogonal to all of them;
///  3. coordinates along which the coefficients of the interpolant have not decayed get more nodes.
///
/// The build is met when all three find nothing, fresh points agree within 0.6 of the tolerance, some uniform
/// (the exploration), some where the latest two interpolants differ most, no climb from errors that stand out
/// finds more (error_climb.h), and the challenge, if there is one, finds nothing. No number of calls can
/// exclude a feature that none of them touches. References: S. Dolgov and D. Savostyanov, Parallel cross
/// interpolation for high-precision calculation of high-dimensional integrals, Comput. Phys. Commun. 246
/// (2020); Y. Nunez Fernandez et al., Learning tensor networks with tensor cross interpolation, SciPost Phys.
/// 18, 104 (2025); L. Reichel, BIT 30 (1990) for the nodes.
///
/// Usage:
///   const SamplingResult result = sample({{{"C_D"}, 0.5, 2.0}, {{"m", "kg"}, 1.0, 2.0}}, {{"v", "m/s"}},
///                                        [](const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {..});
///   if (!result.tolerance_met()) report(result.message);
///   use(*result.field);
namespace samara::pgd {

struct SampledCoordinate {
  Axis::Label label;
  double lower = 0.0;
  double upper = 0.0;
  /// Whether a transform is tried out, if the label has none: for lower > 0 and upper > 1.5 lower the
  /// logarithm, the reciprocal and the square root, by the decay along a few lines.
  bool try_transforms = true;
};

/// Sets values.col(j) (one row per output, sized and zero) at points.col(j) (one row per coordinate, in the
/// coordinate's unit). It is called with one or more points at a time and may use threads. A point is asked
/// for at most once, unless it was part of a batch from which an exception came.
using PointsFunction = std::function<void(const Eigen::MatrixXd& points, Eigen::MatrixXd& values)>;

struct SamplingResult;

struct SamplingOptions {
  /// Largest error of an output at a check point, over the range of that output's values seen (over its size
  /// where the range is the rounding of a constant, see fields/error_scale.h).
  double tolerance = 1e-4;
  /// Floor per output for the range it is divided by, in the output's unit; empty: none.
  Eigen::VectorXd absolute = {};
  long max_calls = 100'000;  ///< guard and check included
  double max_seconds = 0.0;  ///< looked at before every batch; 0: not used
  int max_rank = 400;
  int max_nodes = 65;  ///< per coordinate, 3 to kMostLejaPoints
  /// Uniform points that are called before the tolerance may be called met; 0: 30 for every coordinate and
  /// one for every two hundred calls allowed.
  int exploration_points = 0;
  /// Asked about a field that has passed all checks: points (coordinates x points) at which it was found
  /// wrong; none: nothing was found. The points go into the sample, and the build goes on. Calls that the
  /// challenge makes itself are not counted.
  std::function<Eigen::MatrixXd(const SamplingResult& claim)> challenge = {};
  std::uint64_t seed = 1;
  Eigen::MatrixXd start = {};  ///< points to take pivots near, coordinates x points: SamplingResult::pivots
  ProgressCallback progress = {};
};

struct SamplingRound {
  long calls = 0;      ///< so far
  double error = 0.0;  ///< largest at this round's guard points
  std::vector<int> ranks, nodes;
};

struct SamplingResult {
  /// The best so far, by the guard's error; empty only if not even the first round could be finished.
  std::optional<TrainField> field;
  /// converged: all checks agree to the tolerance, and the challenge found nothing. Else max_calls, max_seconds,
  /// exhausted, stagnated, noise, refuted, not_finite (at bad_point), failed (the function threw an exception
  /// there, the message quotes it) or cancelled.
  Termination status = Termination::failed;
  std::string message = "sample() was not called";
  /// Largest and root mean square error over ranges, at points that the builder did not choose: the check
  /// points if it was met, else the guard points of the best round. Infinite without a field.
  double error = 0.0, root_mean_square_error = 0.0;
  int points_checked = 0;
  /// Where the error is largest among them: a kink or a pole of a function that cannot be resolved.
  std::vector<double> worst_point;
  long calls = 0;          ///< distinct points
  double grid_size = 0.0;  ///< points of the grid the crosses lie in
  Eigen::VectorXd range;   ///< per output, largest less smallest value seen
  Eigen::VectorXd scale;   ///< per output, what errors are divided by (fields/error_scale.h)
  /// Root mean square of what neighbouring points do not share, over the scale, the largest output; nothing
  /// where the build gave no reason to look for it.
  std::optional<double> noise;
  Eigen::MatrixXd pivots;  ///< coordinates x points: a start for a similar function
  std::vector<double> bad_point;
  std::vector<SamplingRound> history;
  double seconds = 0.0;

  bool tolerance_met() const { return status == Termination::converged; }
};

/// @throws ArgumentError if there is no function, coordinate or output, an interval is empty or not finite,
/// names repeat, or an option is out of range. What the function throws does not pass: see
/// SamplingResult::status; what the progress callback throws does.
SamplingResult sample(const std::vector<SampledCoordinate>& coordinates,
                      const std::vector<OutputLabel>& outputs, const PointsFunction& function,
                      const SamplingOptions& options = {});

}  // namespace samara::pgd
