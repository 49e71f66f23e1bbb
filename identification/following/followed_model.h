#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/following/follow_options.h"
#include "samara/models/interface/parametric_model.h"

/// Internal to identification/: what is followed, with all names resolved.
namespace samara::identification {

/// The noise of the model that a state has by its unit; null: none.
double ModelNoise::*noise_by_unit(const models::StateInfo& state);

/// What is seen of a state: one of its numbers, or an output that follows from them.
struct SeenOutput {
  std::string name = {};
  bool is_state = true;
  Eigen::Index index = 0;  ///< of the state, or of the output of the model
  double noise = 0.0;      ///< standard deviation of a frame, SI; 0 where it is not measured
  double period = 0.0;     ///< 0: none
};

/// A point is the states, then the coefficients. An error is what moves a point: by adding, by a factor (logarithmic
/// coefficients), by a turn in body axes (the four states of an attitude: three errors).
class FollowedModel {
 public:
  /// @throws ArgumentError as Follower
  FollowedModel(std::shared_ptr<const models::Model> model, const FollowOptions& options);

  const models::ParametricModel& equations() const { return equations_; }
  const FollowOptions& options() const { return options_; }
  Eigen::Index states() const { return states_; }
  Eigen::Index coefficients() const { return coefficients_; }
  Eigen::Index size() const { return states_ + coefficients_; }
  Eigen::Index errors() const { return size() - (attitude_ ? 1 : 0); }
  /// The first of the four states of the attitude, and of its three errors.
  std::optional<Eigen::Index> attitude() const { return attitude_; }
  /// The error of a state that is no part of the attitude, and of a coefficient.
  Eigen::Index error_of_state(Eigen::Index state) const;
  Eigen::Index error_of_coefficient(Eigen::Index coefficient) const {
    return errors() - coefficients_ + coefficient;
  }
  const std::vector<std::string>& error_names() const { return error_names_; }

  /// Measured outputs, without the attitude.
  const std::vector<SeenOutput>& measured() const { return measured_; }
  bool attitude_is_measured() const { return options_.attitude_noise.has_value(); }
  /// Numbers that are compared in a frame in which all is seen.
  Eigen::Index compared() const { return std::ssize(measured_) + (attitude_is_measured() ? 3 : 0); }
  /// @throws ArgumentError for a name that is no state and no output
  SeenOutput output(const std::string& name) const;

  /// to = from moved by the error; quaternions keep unit length, coefficients their bounds.
  void plus(const Eigen::VectorXd& from, const Eigen::VectorXd& error, Eigen::VectorXd& to) const;
  /// The error that leads from one point to another.
  void minus(const Eigen::VectorXd& to, const Eigen::VectorXd& from, Eigen::VectorXd& error) const;
  /// d(point)/d(error) at no error: rows x size() times it, into rows x errors().
  void times_plus(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& at, Eigen::MatrixXd& product) const;
  /// d(errors of states)/d(states) at a point times states() x errors(), into the upper rows of `product`.
  void minus_times(const Eigen::VectorXd& at, const Eigen::MatrixXd& matrix, Eigen::MatrixXd& product) const;
  /// Moves a covariance of errors about `from` to errors about the point that `error` leads to: an attitude's axes
  /// have turned. @param scratch errors() x errors()
  void carry(const Eigen::VectorXd& error, Eigen::MatrixXd& covariance, Eigen::MatrixXd& scratch) const;

  /// Variances that white noise gives the errors, per second.
  const Eigen::VectorXd& noise_rates() const { return noise_rates_; }

 private:
  void resolve_outputs();
  void resolve_noise();

  FollowOptions options_;
  models::ParametricModel equations_;
  Eigen::Index states_ = 0, coefficients_ = 0;
  std::optional<Eigen::Index> attitude_;
  std::vector<SeenOutput> measured_;
  std::vector<std::string> error_names_;
  Eigen::VectorXd noise_rates_;
};

/// The derivative of a turn's error by the rotation vector from which it is counted: exp(r + d) = exp(r) exp(J d).
Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& rotation);

}  // namespace samara::identification
