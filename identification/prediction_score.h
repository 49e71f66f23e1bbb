#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

/// How well a motion is predicted beyond a window that was seen, beside predictions that know no physics.
///
/// The fit inside the window is no merit: a cubic wins it and predicts worst. What counts is the error on
/// frames after the window, of captures whose coefficients were fitted without them.
///
/// Baselines are polynomials in time, fitted by least squares to each component of the positions in the
/// window: the straight line (degree 1), the parabola (2) and the cubic (3) to all of it; "constant velocity"
/// and "constant acceleration" (degrees 1 and 2) to its last third, at least 5 frames: they follow the state
/// at the end of the window.
namespace samara::identification {

enum class Baseline { straight_line, quadratic, cubic, constant_velocity, constant_acceleration };

/// "straight line", "quadratic", "cubic", "constant velocity", "constant acceleration".
std::string to_string(Baseline baseline);
/// All of them, in that order.
const std::vector<Baseline>& all_baselines();

/// What a camera saw: times (s), and frames x components (1 to 3 of a position, m), NaN where missing.
struct SeenMotion {
  Eigen::VectorXd times = {};
  Eigen::MatrixXd positions = {};
};

/// The baseline's positions at other times, times x components. A component with too few frames for its
/// degree (degree + 1) is NaN.
/// @throws ArgumentError for sizes that differ or times that are not finite.
Eigen::MatrixXd predict(Baseline baseline, const SeenMotion& window, const Eigen::VectorXd& times);

/// Distances between prediction and measurement, frame by frame; frames with a component missing in either
/// are left out.
/// @throws ArgumentError for shapes that differ.
std::vector<double> prediction_distances(const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& measured);

/// Distances of one predictor, from one or many captures, as statistics.
struct PredictionScore {
  std::string predictor = {};  ///< "model", "straight line", ..
  std::string quantity = {};   ///< what was compared, with the horizon: "position, 0.1 s ahead"
  std::string unit = "m";
  int captures = 0;
  int count = 0;        ///< of distances
  double median = 0.0;  ///< NaN if there are none
  double rms = 0.0;
  double largest = 0.0;
};

/// Gathers distances over captures.
class PredictionTally {
 public:
  PredictionTally(std::string predictor, std::string quantity, std::string unit = "m");

  /// One capture's; nothing is counted if it is empty.
  void add(const std::vector<double>& distances);
  PredictionScore score() const;

 private:
  PredictionScore score_;
  std::vector<double> distances_;
};

}  // namespace samara::identification
