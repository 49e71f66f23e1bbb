#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

/// Least squares by polynomials around a time; internal to identification/.
namespace samara::identification {

/// The frames that a local fit may use, and how it picks them.
struct LocalFrames {
  Eigen::VectorXd times;    ///< s, strictly increasing
  Eigen::VectorXd weights;  ///< one per frame; 0: never used
  int degree = 4;
  double bandwidth = 0.0;  ///< s
  /// Noise is a running mean over so many frames: that of frames less than so many intervals apart is
  /// correlated.
  int averaged = 1;
  double interval = 0.0;  ///< s, between frames

  Eigen::Index count() const { return times.size(); }
  /// The frames with a weight within half a bandwidth of t, shifted inward at an end of the record; where
  /// these are fewer than degree + 2, the nearest degree + 2 (all, if there are not so many).
  /// @param but a frame to leave out; -1: none
  std::vector<Eigen::Index> around(double t, Eigen::Index but = -1) const;
  /// The nearest frames with a weight, in order; fewer if there are not so many.
  std::vector<Eigen::Index> nearest(double t, std::size_t wanted, Eigen::Index but = -1) const;
};

/// A polynomial in t - t0 for each of some coordinates.
struct LocalPolynomial {
  Eigen::MatrixXd derivatives;  ///< at t0; rows: order 0, 1, 2; columns: coordinates
  Eigen::Vector3d deviations;   ///< standard deviations of those for noise of size 1 and weight 1
  double with_frame = 0.0;      ///< covariance of its value with the noise of a frame at t0, likewise
  Eigen::MatrixXd residuals;    ///< of the frames it was fitted to
  double span = 0.0;            ///< s, of the frames it was fitted to

  /// Of the distance between its value and a frame at t0, for noise of size 1.
  double distance_variance() const { return 1.0 + deviations[0] * deviations[0] - 2.0 * with_frame; }
};

/// Weighted least squares.
/// @param values rows: `frames`; columns: coordinates
/// @param weights one for each of `frames`
LocalPolynomial fit_local(const LocalFrames& all, const std::vector<Eigen::Index>& frames, double t0,
                          const Eigen::VectorXd& weights, const Eigen::MatrixXd& values);

/// Coordinates of some frames (rows) as frame `reference` sees them: the values themselves, or rotation
/// vectors from its attitude.
using LocalChart =
    std::function<Eigen::MatrixXd(Eigen::Index reference, const std::vector<Eigen::Index>& frames)>;

struct RobustOptions {
  double threshold = 5.0;
  std::optional<double> noise = {};
  double least_noise = 0.0;  ///< below it, deviations are rounding
};

/// Sets the weights to 0 for outliers and to 1 for others: see smoothing.h. Where more than half would be
/// outliers, or fewer than degree + 2 frames were left, to 1.
void weigh_outliers(LocalFrames& frames, const LocalChart& chart, Eigen::Index coordinates,
                    const RobustOptions& options);

/// Standard deviation of a frame's noise in one coordinate, from the residuals of fits around each frame.
double residual_noise(const LocalFrames& frames, const LocalChart& chart, Eigen::Index coordinates);

}  // namespace samara::identification
