#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "samara/identification/forecasts/baseline_scores.h"
#include "samara/identification/forecasts/covariant_regression.h"
#include "samara/identification/forecasts/recent_motion.h"

/// Where a motion with two level components goes, by a regression that turns with it (covariant_regression.h). Its
/// features are the known numbers of the motion, and of every component orthogonal polynomials up to degree 6 through the
/// places of the whole way back, an interval or less apart. The kernel sees polynomials up to degree 4, of the components
/// that do not turn a third. Moments that the first prediction missed by far teach what lies four median misses from it.
namespace samara::identification {

/// One moment of the training. What it points to must outlive the fit.
struct TurningMoment {
  int motion = 0;
  std::size_t part = 0;  ///< of the training
  const SeenMotion* seen = nullptr;
  const Eigen::VectorXd* known = nullptr;
  Eigen::RowVectorXd moved = {};   ///< from the last place seen to the next
  Eigen::RowVectorXd missed = {};  ///< from the first prediction, found without the part, to the next
};

class TurningPrediction {
 public:
  /// Not fitted for fewer than twelve motions, whose parts say little of another motion, and where the mean with the first
  /// prediction does not predict the parts better, each from the others and all moments together.
  /// @param components two level ones  @param way_back intervals
  static TurningPrediction fit(std::span<const TurningMoment> moments, const Components& components,
                               double way_back);

  bool is_fitted() const { return regression_.is_fitted(); }

  /// From the last place seen. @throws ArgumentError before a fit, and for a motion of other components or known numbers
  Eigen::RowVectorXd moved(const SeenMotion& seen, const Eigen::VectorXd& known) const;
  /// The same as found without a part of the training.
  Eigen::RowVectorXd moved_without(std::size_t part, const SeenMotion& seen,
                                   const Eigen::VectorXd& known) const;

 private:
  Turning features_of(const SeenMotion& seen, const Eigen::VectorXd& known) const;

  Components components_ = {};
  double way_back_ = 0.0;
  Eigen::MatrixXd polynomials_ = {};  ///< degrees x places
  CovariantRegression regression_ = {};
};

}  // namespace samara::identification
