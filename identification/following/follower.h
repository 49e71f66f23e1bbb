#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/following/follow_options.h"
#include "samara/identification/forecasts/forecast.h"
#include "samara/models/interface/model.h"

/// A motion followed frame by frame: where it is, which coefficients it has now, and what comes next.
///
///     Follower follower(model, options);                    // options_of_fit() makes them of a fit
///     for (each frame) follower.add(time, values);
///     const Forecast ahead = follower.forecast(times);      // s, of the clock of the frames
///
/// An iterated extended Kalman filter (B. M. Bell, F. W. Cathey, IEEE Trans. Autom. Control 38 (1993) 294-297) of the
/// states and of the coefficients that are not held, with the exact derivatives of the model's Runge-Kutta steps. An
/// attitude moves by turns in body axes (F. L. Markley, J. Guid. Control Dyn. 26 (2003) 311-317), and stays a unit
/// quaternion; coefficients that are logarithmic move by factors. White noise in the rates of velocities stands for
/// what the model lacks.
///
/// The start is found from the first frames: the most likely start by Levenberg and Marquardt's method from each of
/// several attitudes where none is measured. Starts that differ are hypotheses, each followed by a filter of its own;
/// their weights are their likelihoods. Forecasts are their mixture.
///
/// What is said after a frame depends on no later frame. After the start nothing is allocated by add(). One object per
/// thread.
namespace samara::identification {

enum class FollowStatus {
  starting,   ///< too few frames so far
  following,  ///< the frame was taken in
  outlier,    ///< it was too far from what was expected, and counted less
  blind,      ///< nothing was seen in it
  lost,       ///< too many outliers in a row: a start is looked for from the next frames on
};

/// "starting", "following", "outlier", "blind", "lost".
std::string to_string(FollowStatus status);

/// What a frame did.
struct FollowedFrame {
  FollowStatus status = FollowStatus::starting;
  int values = 0;  ///< that were compared; an attitude counts as three
  /// Of the most likely hypothesis before the frame: r^T S^-1 r, of chi^2 distribution with `values` degrees of freedom
  /// where model and noise are right. NaN where nothing was compared.
  double innovation_squared = std::numeric_limits<double>::quiet_NaN();
  /// Logarithm of the probability density of the frame before it was seen, all hypotheses together; 0 where nothing
  /// was compared or a start was looked for.
  double log_likelihood = 0.0;
  int hypotheses = 0;  ///< after it
};

/// What is known of the motion, for one hypothesis.
struct FollowedState {
  double time = 0.0;                  ///< s, of the state: of the last frame; half a mean of frames earlier
  double weight = 1.0;                ///< of all hypotheses 1 together
  Eigen::VectorXd states = {};        ///< of the model, in its order, SI
  Eigen::VectorXd coefficients = {};  ///< in the order of FollowOptions::coefficients, SI
  /// Of the errors: for each state one, but three for an attitude (its turn in body axes, rad), then one for each
  /// coefficient (of its logarithm if logarithmic).
  Eigen::MatrixXd covariance = {};
};

class Follower {
 public:
  /// @throws ArgumentError for names that the model has not, required parameters that are missing, options outside
  /// their meaning, and if nothing is measured.
  Follower(std::shared_ptr<const models::Model> model, const FollowOptions& options);
  ~Follower();
  Follower(Follower&&) noexcept;
  Follower& operator=(Follower&&) noexcept;

  /// What values are given of, in order: the outputs of FollowOptions::noise, then the four states of the attitude if
  /// it is measured.
  const std::vector<std::string>& measured() const;

  /// Takes the next frame in.
  /// @param time s, later than that of the frame before; not negative
  /// @param values of measured(), SI; NaN where not seen (an attitude: all four or none)
  /// @throws ArgumentError for a time that is not finite or not later than the last, for an infinite value, for
  /// another number of values, and for an attitude of length 0; the motion is then where it was.
  FollowedFrame add(double time, std::span<const double> values);

  /// Whether there is a state: the start was found, and not lost since.
  bool is_following() const;
  /// s, of the last frame; negative before the first.
  double time() const;

  /// The most likely hypothesis.
  /// @throws ArgumentError if there is none yet.
  FollowedState state() const;
  /// All of them, the most likely first; none before the start.
  std::vector<FollowedState> states() const;
  /// Names of the errors of FollowedState::covariance: "x", "turn about x", "C_D".
  const std::vector<std::string>& error_names() const;
  /// Standard errors of the states of the model and of the coefficients, in SI (of an attitude those of its four
  /// numbers).
  Eigen::VectorXd deviations(const FollowedState& state) const;

  /// What would be measured at later times: means and covariances of frames there, the noise of a frame among them,
  /// one component for each hypothesis, the most likely first.
  /// @param times s, of the clock of the frames: not before the last frame, not decreasing
  /// @param outputs states or outputs of the model; empty: those of FollowOptions::noise. Of those that are not
  ///   measured the covariance has no noise of a frame.
  /// @returns no component before the start; rows of NaN from where a hypothesis has no finite motion
  /// @throws ArgumentError for times that are not finite, decrease or are earlier, and for an unknown output.
  Forecast forecast(std::span<const double> times, const std::vector<std::string>& outputs = {}) const;

  /// The motion in the light of all frames so far, a state for each of them that stood within a motion followed: the
  /// fixed-interval smoother of H. E. Rauch, F. Tung, C. T. Striebel, AIAA J. 3 (1965) 1445-1450, along the most likely
  /// hypothesis. Weights are 1.
  /// @throws ArgumentError unless FollowOptions::remember is set.
  std::vector<FollowedState> smoothed() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace samara::identification
