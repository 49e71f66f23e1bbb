#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

/// Values, rates and accelerations of a capture, with their standard errors: starting values for fits.
///
/// At each time asked for, a polynomial is fitted by least squares to the frames within half a bandwidth of
/// it (Savitzky and Golay 1964, for frames at any times and with gaps). Where these would reach over the end
/// of the record they are shifted inward; where they are too few (a gap, a small bandwidth), the nearest
/// degree + 2 frames are taken.
///
/// Outliers get no weight: frames whose distance from the polynomial through their *neighbours* is more than
/// `outlier_threshold` times its standard deviation. They are found by iterated reweighting (Cleveland 1979,
/// here with residuals of the frame left out, and from a start of least absolute residuals). Where more than
/// half of the frames would be outliers, or fewer than degree + 2 were left, none is.
///
/// What the standard errors mean: noise of one size over the frames, independent from frame to frame unless
/// `averaged_frames` says otherwise, carried through the fit. They do not know what a polynomial of this
/// degree cannot follow: choose a bandwidth of at most about half a swing.
///
///     const auto start = smooth(times, positions, Eigen::VectorXd::Constant(1, 0.1), {.bandwidth = 0.15});
///     start.value.row(0), start.rate.row(0), start.rate_error.row(0)
namespace samara::identification {

struct SmoothingOptions {
  /// Of the polynomials; 2 to 6.
  int degree = 4;
  /// s: width of the range of frames around each time. None: 15 median intervals between frames.
  std::optional<double> bandwidth = {};
  /// Standard deviation of one frame's noise, in the channel's unit (rad for attitudes). None: estimated for
  /// each channel from the residuals. Outliers are judged by it, or by how the frames scatter if that is
  /// more.
  std::optional<double> noise = {};
  /// The source has replaced each frame by the mean of so many around it: noise of neighbours is correlated.
  /// Without this, errors would come out too small. (What the mean does to the motion is left to the caller:
  /// it adds (n^2 - 1)/24 interval^2 times the acceleration.)
  int averaged_frames = 1;
  /// A frame farther from its neighbours than this many standard deviations counts for nothing. Infinite, or
  /// where that would leave less than half of the frames: every frame counts.
  double outlier_threshold = 5.0;
};

/// Rows: the times asked for; columns: channels.
struct Smoothed {
  Eigen::MatrixXd value;
  Eigen::MatrixXd rate;          ///< 1/s
  Eigen::MatrixXd acceleration;  ///< 1/s^2
  Eigen::MatrixXd value_error;   ///< standard errors
  Eigen::MatrixXd rate_error;
  Eigen::MatrixXd acceleration_error;
  Eigen::MatrixXd span;   ///< s, from the first to the last frame that was used
  Eigen::VectorXd noise;  ///< standard deviation of one frame, for each channel
  /// frames x channels; true where a frame was seen and left out
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> outlier;
};

/// @param times of the frames, s, strictly increasing
/// @param values frames x channels; NaN where a channel was not seen
/// @param at times asked for, s; within the record
/// @throws ArgumentError if sizes do not match, times do not increase, `at` is outside the record by more
///   than a median interval, an option is out of its range, or a channel was seen in fewer than degree + 2
///   frames.
Smoothed smooth(const Eigen::VectorXd& times, const Eigen::MatrixXd& values, const Eigen::VectorXd& at,
                const SmoothingOptions& options = {});

/// An angle, known up to multiples of a period: unwrapped first. One channel.
/// @param period rad: 2 pi; pi for the inclination of a plate whose sides look alike
Smoothed smooth_angle(const Eigen::VectorXd& times, const Eigen::VectorXd& angles, double period,
                      const Eigen::VectorXd& at, const SmoothingOptions& options = {});

}  // namespace samara::identification
