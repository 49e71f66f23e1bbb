#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/forecasts/autoregression.h"

/// How unlike those of the training a motion is: who saw nothing like it foresees it badly.
namespace samara::identification {

/// The course of a motion is where it was six times, equally far apart on way_back(), as seen from the newest place: as
/// a LevelFrame shows it, along the level velocity and across it, and in the other components. Two courses are as far
/// apart as these places, or those of the one's mirror image, whichever is nearer: the root of the sum of squares, in
/// the unit of places. Intervals are each motion's own.
class Novelty {
 public:
  /// Moments are left out that show less than kLeastSeen of the way back, or nothing to recent_motion().
  /// @throws ArgumentError for motions of different numbers of components, and a level component that there is not
  static Novelty fit(std::span<const TrainingMoment> moments, const Components& components);

  /// The mean distance to the five nearest training moments. NaN where there are fewer, the motion was seen too
  /// briefly, or more than two components are level. @throws ArgumentError for another number of components
  double at(const SeenMotion& seen) const;
  /// To those of other clusters.
  double without(int cluster, const SeenMotion& seen) const;

 private:
  struct Course {
    Mirrored places = {};
    int cluster = 0;
  };
  /// Nothing of motions that were seen too briefly.
  std::optional<Mirrored> course_of(const SeenMotion& seen) const;
  double distance(const SeenMotion& seen, std::optional<int> without) const;

  Components components_ = {};
  Eigen::Index count_ = 0;     ///< of components
  Eigen::VectorXd back_ = {};  ///< intervals, the last the whole way
  std::vector<Course> known_ = {};
};

}  // namespace samara::identification
