#pragma once

#include <limits>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "samara/identification/following/followed_model.h"
#include "samara/models/batch/rk4_flow.h"

/// Internal to identification/: one way on, and what a frame does to it.
namespace samara::identification {

/// What smoothing needs of a frame.
struct FrameRecord {
  double time = 0.0;
  Eigen::VectorXd expected, point;              ///< before and after the frame
  Eigen::MatrixXd expected_covariance, covariance;
  Eigen::MatrixXd transition;                   ///< from the frame before to `expected`
};

/// A point with its errors, and how likely it is.
struct Hypothesis {
  Eigen::VectorXd point = {};
  Eigen::MatrixXd covariance = {};
  double log_weight = 0.0;
  std::vector<FrameRecord> records = {};  ///< only if the follower remembers
};

/// What was seen at one time, as numbers of compared(): outputs, then the attitude as a quaternion apart.
struct SeenFrame {
  double time = 0.0;
  Eigen::VectorXd values = {};  ///< of measured(); NaN where missing
  Eigen::Vector4d attitude = Eigen::Vector4d::Constant(std::numeric_limits<double>::quiet_NaN());
  int count = 0;  ///< numbers to compare
};

/// Moves hypotheses and compares them with frames. Scratch space: one per thread.
class HypothesisFilter {
 public:
  explicit HypothesisFilter(const FollowedModel& model);

  /// s between frames: of a mean of frames; longer intervals are parted where model noise comes in.
  void set_interval(double interval);
  double interval() const { return interval_; }
  /// s: from the state to the frame that is compared with it.
  double lead() const;

  /// From time t by a duration. @param transition of errors, if wanted
  /// @returns false if there is no finite motion; the hypothesis is then as it was or moved a part of the way
  bool predict(Hypothesis& hypothesis, double t, double duration, Eigen::MatrixXd* transition = nullptr);

  /// What would be seen of outputs if the point were the state at t, and its derivatives by errors of the point.
  /// @param attitude also the four states of an attitude, after the outputs
  /// @param values outputs (and 4), @param by_errors of as many rows, errors() columns
  /// @param by_errors null: not wanted, which takes a tenth of the time where frames are means
  bool observe(const Eigen::VectorXd& point, double t, const std::vector<SeenOutput>& outputs, bool attitude,
               Eigen::VectorXd& values, Eigen::MatrixXd* by_errors);

  /// What is seen less what would be seen, and the derivatives of the latter by errors of the point: zero where
  /// nothing was seen, where `variances` is 1.
  /// @param by_errors null: not wanted
  bool compare(const Eigen::VectorXd& point, double t, const SeenFrame& frame, Eigen::VectorXd& residuals,
               Eigen::MatrixXd* by_errors, Eigen::VectorXd& variances);

  /// What taking a frame in did.
  struct Update {
    bool is_finite = true;
    double innovation_squared = 0.0;
    double log_likelihood = 0.0;  ///< outliers count as if they were at the gate
    bool is_outlier = false;
  };
  /// @param t of the state
  Update update(Hypothesis& hypothesis, double t, const SeenFrame& frame);

  /// Innovation squared from which on a frame of so many numbers is an outlier.
  double gate(int count) const { return gates_[static_cast<std::size_t>(count)]; }

 private:
  void add_noise(double duration, Eigen::MatrixXd& covariance);

  const FollowedModel& model_;
  models::Rk4Flow flow_, seen_flow_, plain_flow_;  ///< the last without derivatives
  models::ParametricModel::Workspace workspace_;
  std::vector<double> gates_;
  double interval_ = 0.0;
  Eigen::VectorXd moved_, error_, point_, expected_, residuals_, innovations_, variances_, step_, outputs_,
      outputs_by_time_;
  Eigen::MatrixXd by_point_, by_start_, by_flow_, transition_, scratch_, half_, outputs_by_states_,
      outputs_by_parameters_, seen_by_errors_, by_errors_, joseph_, innovation_covariance_;
  Eigen::MatrixXd cross_, gain_;  ///< transposed: compared x errors
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

}  // namespace samara::identification
