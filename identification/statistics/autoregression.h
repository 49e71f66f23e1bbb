#pragma once

#include <map>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/statistics/baseline_scores.h"

/// What the last places of a motion say of the next, as other motions went on: a linear prediction whose
/// weights are found on training motions, and vary with the motion's speed.
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
namespace samara::identification {

/// One moment of a motion: what was seen before it, and where the motion was later.
struct TrainingMoment {
  int cluster = 0;               ///< motions that may resemble each other have the same
  SeenMotion seen = {};          ///< up to the moment
  Eigen::VectorXd known = {};    ///< numbers of the motion, such as its body's size; as many for all
  Eigen::RowVectorXd next = {};  ///< measured at the horizon, which is that of all moments; NaN where missing
};

/// Components that are alike: those of a position that are level. The others stand for themselves.
struct Components {
  std::vector<int> level = {};
};

/// Velocity, acceleration and its change of a cubic through the last frames, at the newest, as displacements in one
/// frame: 3 x components. NaN where fewer than 4 frames show every component.
Eigen::MatrixXd recent_rates(const SeenMotion& seen);

class Autoregression {
 public:
  /// Frames that count, the newest among them.
  static constexpr int kPlaces = 12;

  /// Weights from moments of two clusters or more; those without a next place or too few frames are left out.
  /// @throws ArgumentError for moments of different numbers of components or known numbers, and for a level
  ///   component that there is not
  static Autoregression fit(std::span<const TrainingMoment> moments, const Components& components);

  /// Whether there were enough moments, of enough clusters: else every prediction is NaN.
  bool is_fitted() const { return !without_.empty(); }

  /// Of a motion with the same components. NaN where too few frames were seen.
  Eigen::RowVectorXd predict(const SeenMotion& seen, const Eigen::VectorXd& known) const;

  /// The same by weights found without a cluster of the training, and those that were left out with it.
  Eigen::RowVectorXd predict_without(int cluster, const SeenMotion& seen, const Eigen::VectorXd& known) const;

 private:
  struct Weights {
    Eigen::VectorXd level = {};  ///< of the level components
    Eigen::MatrixXd own = {};    ///< terms x the others
  };
  struct Steps;  ///< of the fit
  Eigen::RowVectorXd predict(const Weights& weights, const SeenMotion& seen,
                             const Eigen::VectorXd& known) const;

  Components components_ = {};
  Eigen::VectorXd middle_ = {}, width_ = {};  ///< of speeds and known numbers
  Weights weights_ = {};
  std::map<int, std::size_t> part_of_ = {};  ///< of each cluster
  std::vector<Weights> without_ = {};        ///< each part
};

}  // namespace samara::identification
