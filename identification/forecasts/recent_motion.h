#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/forecasts/baseline_scores.h"

/// What the newest frames of a motion show, and how it looks along its own level velocity.
namespace samara::identification {

/// Components that are alike: those of a position that are level. The others stand for themselves.
struct Components {
  std::vector<int> level = {};
};

/// The others, of so many.
std::vector<int> others_of(const Components& components, Eigen::Index count);

/// Velocity, acceleration and its change of a cubic through the last frames, at the newest, as displacements in one
/// frame: 3 x components. NaN where fewer than 4 frames show every component.
Eigen::MatrixXd recent_rates(const SeenMotion& seen);

/// Displacements are as seen from the newest place; an interval is the median one between frames.
struct RecentMotion {
  /// Places that are taken, the newest among them, an interval apart.
  static constexpr int kPlaces = 12;

  Eigen::RowVectorXd last = {};
  Eigen::MatrixXd places = {};  ///< from one interval back on: kPlaces - 1 x components
  Eigen::MatrixXd rates = {};   ///< of recent_rates()
  double seen_for = 0.0;        ///< intervals
};

/// Nothing where fewer than four frames show every component. Between frames motions go on straight lines, and before
/// the first one as they were first seen.
std::optional<RecentMotion> recent_motion(const SeenMotion& seen);

/// How far back motions are compared with each other, in intervals: the median of what those of the training were seen
/// for, 24 at most.
double way_back(const std::vector<double>& seen_for);
/// A motion that was seen for less than this part of the way back is not compared.
inline constexpr double kLeastSeen = 0.75;

/// Displacements some intervals back, a row each, by the same rules.
Eigen::MatrixXd places_back(const SeenMotion& seen, const Eigen::VectorXd& intervals);

/// Views some intervals back from the newest place, a row each: on straight lines between frames that show all of them,
/// and as in the nearest one before the first and after the last. NaN where there is none.
Eigen::MatrixXcd views_back(const SeenMotion& seen, const Eigen::VectorXd& intervals);

/// Numbers of a motion that a mirror leaves as they are, and those whose sign it turns.
struct Mirrored {
  Eigen::VectorXd even = {}, odd = {};
};

/// Displacements along the level velocity (even) and across it (odd); the other components are even. With one level
/// component there is no frame: it is odd. So what is learned of these holds however a motion is turned about the
/// vertical, and for its mirror image.
class LevelFrame {
 public:
  /// @param components two level ones at most
  /// @param velocity of all components
  LevelFrame(const Components& components, const Eigen::RowVectorXd& velocity);

  /// @param displacements a row each
  Mirrored split(const Eigen::MatrixXd& displacements) const;
  /// The one displacement of which these are the numbers.
  Eigen::RowVectorXd joined(const Mirrored& numbers) const;

 private:
  std::vector<int> level_ = {}, others_ = {};
  Eigen::RowVector2d along_ = {1.0, 0.0};
};

}  // namespace samara::identification
