#pragma once

#include <map>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/forecasts/baseline_scores.h"
#include "samara/identification/forecasts/kernel_correction.h"
#include "samara/identification/forecasts/recent_motion.h"
#include "samara/identification/forecasts/turning_prediction.h"

/// What the last places of a motion say of the next, as other motions went on: a linear prediction whose
/// weights are found on training motions, and vary with the motion's speed; and what such a prediction missed in
/// moments like this one (kernel_correction.h).
///
/// With the places p_k of the last frames as seen from the newest, and velocity, acceleration and their change
/// d_1, d_2, d_3 of a cubic through them, the displacement at one horizon is
///
///     sum_k c_k p_k + sum_ij e_ij z_i d_j,
///
/// z_i speeds and known numbers of the motion, each bounded: tanh of its distance from the training motions'
/// median. The level components have the same weights c and e, so that no direction is preferred; every other
/// component has its own, a constant, and terms in z_i and z_i z_j. Weights are those of least squares, robust
/// (Huber), with a penalty on their squares that training motions choose: each fifth predicted by the others.
///
/// The correction's features are d_1, d_2, d_3 and the places a quarter, a half, three quarters of, and the whole way
/// back that training moments were seen, along the level velocity and across it; the other components of these; and
/// the known numbers. It learns what each fifth's motions had left when the others predicted them. A motion seen for
/// less than three quarters of that way is not corrected, nor are motions with three level components or more.
///
/// Motions with two level components may have a second prediction, which turns with them and looks at views, too
/// (turning_prediction.h): what is predicted is the mean of both then, or the second alone.
namespace samara::identification {

/// One moment of a motion: what was seen before it, and where the motion was later.
struct TrainingMoment {
  int cluster = 0;               ///< motions that may resemble each other have the same
  SeenMotion seen = {};          ///< up to the moment
  Eigen::VectorXd known = {};    ///< numbers of the motion, such as its body's size; as many for all
  Eigen::RowVectorXd next = {};  ///< measured at the horizon, which is that of all moments; NaN where missing
};

class Autoregression {
 public:
  /// Weights from moments of two clusters or more; those without a next place or too few frames are left out.
  /// @throws ArgumentError for moments of different numbers of components or known numbers, and for a level
  ///   component that there is not
  static Autoregression fit(std::span<const TrainingMoment> moments, const Components& components);

  /// Whether there were enough moments, of enough clusters: else every prediction is NaN.
  bool is_fitted() const { return !without_.empty(); }
  /// Of the linear prediction; it may be none.
  const KernelCorrection& correction() const { return correction_; }
  /// The second prediction; it may be none.
  const TurningPrediction& turning() const { return turning_; }

  /// Of a motion with the same components. NaN where too few frames were seen.
  Eigen::RowVectorXd predict(const SeenMotion& seen, const Eigen::VectorXd& known) const;

  /// The same by weights found without a cluster of the training, and those that were left out with it; only penalty,
  /// lengths and what the correction has left to learn were found with it.
  Eigen::RowVectorXd predict_without(int cluster, const SeenMotion& seen, const Eigen::VectorXd& known) const;

 private:
  struct Weights {
    Eigen::VectorXd level = {};  ///< of the level components
    Eigen::MatrixXd own = {};    ///< terms x the others
  };
  struct Steps;  ///< of the fit
  static constexpr std::size_t kNoPart = static_cast<std::size_t>(-1);
  /// @param without a part of the training; kNoPart: by all of it
  Eigen::RowVectorXd predict(std::size_t without, const SeenMotion& seen, const Eigen::VectorXd& known) const;
  /// The linear one with its correction.
  Eigen::RowVectorXd first_prediction(std::size_t without, const SeenMotion& seen, const RecentMotion& recent,
                                      const Eigen::VectorXd& known) const;

  Components components_ = {};
  Eigen::VectorXd middle_ = {}, width_ = {};  ///< of speeds and known numbers
  Weights weights_ = {};
  std::map<int, std::size_t> part_of_ = {};  ///< of each cluster
  std::vector<Weights> without_ = {};        ///< each part
  double way_back_ = 0.0;                    ///< intervals, of the oldest place that the correction sees
  KernelCorrection correction_ = {};
  TurningPrediction turning_ = {};
};

}  // namespace samara::identification
