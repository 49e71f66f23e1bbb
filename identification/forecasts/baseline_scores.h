#pragma once

#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/forecasts/proper_scores.h"

/// How well a motion is predicted beyond a span that was seen, beside predictions that know no physics.
///
/// The fit inside the span is no merit: a cubic wins it and predicts worst. What counts is the error on
/// frames after the span, of captures whose coefficients were fitted without them.
///
/// Baselines are polynomials in time, fitted by least squares to each component of the positions in the
/// span: the straight line (degree 1), the parabola (2) and the cubic (3) to all of it; "constant velocity"
/// and "constant acceleration" (degrees 1 and 2) to its last third, at least 5 frames: they follow the state
/// at the end of the span. "Measured velocity" is for sensors that say how fast a component changes: a
/// straight line through that over the span, carried on from the place on which all frames agree best.
/// Attitudes are predicted as rotation vectors from the last one seen.
///
/// "Point with drag" is the least physics: a point that weighs, less what buoyancy takes off, and is braked by
/// k |v| v, its start and k of each span's own (point_with_drag.h). It needs a component that is up.
namespace samara::identification {

enum class Baseline {
  straight_line,
  quadratic,
  cubic,
  constant_velocity,
  constant_acceleration,
  measured_velocity,
  point_with_drag
};

/// "straight line", "quadratic", "cubic", "constant velocity", "constant acceleration", "measured velocity",
/// "point with drag".
std::string to_string(Baseline baseline);
/// All of them, in that order.
const std::vector<Baseline>& all_baselines();

inline constexpr double kStandardG = 9.80665;  ///< m/s^2

/// What a camera saw: times (s), and frames x components (1 to 3 of a position, m), NaN where missing.
struct SeenMotion {
  Eigen::VectorXd times = {};
  Eigen::MatrixXd positions = {};
  /// How fast they change as a sensor says it, frames x components; NaN where it does not. May be empty.
  Eigen::MatrixXd rates = {};
  Eigen::Index up = -1;            ///< the component against gravity; below 0: none is
  double net_weight = kStandardG;  ///< m/s^2, of a body: weight less buoyancy, by its mass; below 0: it rises
  /// What two cameras show of the body besides its place, such as sizes and shapes of its silhouette: real parts as
  /// seen along the first level component, imaginary ones as seen along the second; frames x numbers, NaN where
  /// missing. May be empty. Baselines do not look at it.
  Eigen::MatrixXcd views = {};
};

/// Attitudes that were seen: quaternions (w, x, y, z), body to world, of any length but 0; NaN where missing.
struct SeenTurn {
  Eigen::VectorXd times = {};
  Eigen::MatrixX4d attitudes = {};
  Eigen::MatrixX3d body_rates = {};  ///< w_WB_B as a sensor says it, rad/s; may be empty
};

/// The baseline's positions at other times, times x components. A component with too few frames for its
/// degree (degree + 1; for the measured velocity 2 with a rate) is NaN; so are all of the point with drag where
/// no component is up or fewer than 4 frames show all of them.
/// @throws ArgumentError for sizes that differ or times that are not finite.
Eigen::MatrixXd predict(Baseline baseline, const SeenMotion& span, const Eigen::VectorXd& times);

/// By how much the noise of single values grows on the way to a time: the root of the sum of squares of the weights
/// with which the baseline adds them up; the largest of all components. For the measured velocity these are weights of
/// rates, in s; a point with drag counts as a parabola. NaN where the baseline gives none.
/// @throws ArgumentError as predict()
double noise_gain(Baseline baseline, const SeenMotion& span, double time);

/// The baseline's attitudes at other times, not before those seen: unit quaternions, or NaN.
/// @throws ArgumentError as above, and for a quaternion of length 0.
Eigen::MatrixX4d predict_turn(Baseline baseline, const SeenTurn& span, const Eigen::VectorXd& times);

/// Distances between prediction and measurement, frame by frame; frames with a component missing in either
/// are left out.
/// @throws ArgumentError for shapes that differ.
std::vector<double> prediction_distances(const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& measured);

/// Angles of the turns between predicted and measured attitudes [rad], frame by frame, likewise.
std::vector<double> turn_distances(const Eigen::MatrixX4d& predicted, const Eigen::MatrixX4d& measured);

/// Distances of one predictor, from one or many captures, as statistics.
struct PredictionScore {
  std::string capture = {};    ///< the one whose distances these are; empty: all of them together
  std::string file = {};       ///< of the capture: others may have its id; empty of all together
  std::string predictor = {};  ///< "model", "straight line", ..
  std::string quantity = {};   ///< what was compared, with the horizon: "position, 0.1 s ahead"
  std::string unit = "m";
  int captures = 0;
  int count = 0;        ///< of distances
  double median = 0.0;  ///< NaN if there are none
  double rms = 0.0;
  double largest = 0.0;
  /// The mean CRPS and the shares of values in the central 50 and 90 % of what was forecast (proper_scores.h);
  /// NaN where no errors of training motions are known.
  double crps = std::numeric_limits<double>::quiet_NaN();
  double coverage50 = std::numeric_limits<double>::quiet_NaN();
  double coverage90 = std::numeric_limits<double>::quiet_NaN();
  /// Standard error of the share in the band of 90 %, captures being drawn anew; NaN for a single capture.
  double coverage90_error = std::numeric_limits<double>::quiet_NaN();
  /// The median less that of the best of the baselines that say most, both over what both say
  /// (PredictionTally::behind), and the scatter of this difference when captures are drawn anew (bootstrap); NaN for a
  /// single capture.
  double behind_best = std::numeric_limits<double>::quiet_NaN();
  double behind_best_error = std::numeric_limits<double>::quiet_NaN();
  /// No other predictor of the quantity has a smaller median. If it is not the model, the model loses.
  bool best = false;
};

/// Gathers distances over captures.
class PredictionTally {
 public:
  PredictionTally(std::string predictor, std::string quantity, std::string unit = "m");

  /// One capture's, or those of one of its spans; nothing is counted if it is empty.
  /// @param cluster captures that are drawn together for errors; below 0: one of its own
  void add(const std::vector<double>& distances, int cluster = -1);
  /// What proper scores need of one number that was forecast. NaN: missing, not counted.
  /// @param cluster of its capture, as of add(), never below 0
  void add_forecast(const NormalMixture& mixture, double measured, int cluster) {
    proper_.add(mixture, measured, cluster);
  }
  PredictionScore score() const;

  /// The difference of medians, this one's less another's, and its bootstrap error over clusters. Only calls of add()
  /// count that gave both as many distances: who is silent where it is hard gains nothing.
  /// @param other was given the same captures, in the same order
  struct Difference {
    double value, error;
  };
  Difference behind(const PredictionTally& other) const;

 private:
  /// Only the distances of calls that gave the other as many.
  PredictionTally shared_with(const PredictionTally& other) const;
  std::vector<double> drawn(const std::vector<int>& clusters) const;

  PredictionScore score_;
  std::vector<double> distances_;
  std::vector<int> clusters_, calls_;  ///< of each distance
  int calls_so_far_ = 0;               ///< of add(), empty ones too, so that tallies agree on captures
  ProperScores proper_;
};

}  // namespace samara::identification
