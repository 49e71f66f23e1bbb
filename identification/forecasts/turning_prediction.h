#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "samara/identification/forecasts/baseline_scores.h"
#include "samara/identification/forecasts/covariant_regression.h"
#include "samara/identification/forecasts/recent_motion.h"

/// Where a motion with two level components goes, by a regression that turns with it (covariant_regression.h). Its
/// features are the known numbers of the motion, and of every component orthogonal polynomials up to degree 6 through
/// the places of the whole way back, an interval or less apart. The kernel sees polynomials up to degree 4, of the
/// components that do not turn a third. Where all moments show views, and parts of the training are foreseen better
/// with them, polynomials from degree 0 to 4 of each of their numbers are features too, by a third. Moments that the
/// first prediction missed by far teach what lies four median misses from it.
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
  /// Not fitted for fewer than twelve motions, whose parts say little of another motion, and where what is predicted
  /// with it by its share does not foresee the parts better, each from the others and all moments together.
  /// @param components two level ones, else ArgumentError  @param way_back intervals
  static TurningPrediction fit(std::span<const TurningMoment> moments, const Components& components,
                               double way_back);

  bool is_fitted() const { return regression_.is_fitted(); }
  /// Whether it looks at views.
  bool sees_views() const { return view_polynomials_.size() > 0; }
  /// Of it in what is predicted, the rest being the first prediction's, which looks at no views: all where it does.
  double share() const { return sees_views() ? 1.0 : 0.5; }
  /// Whether the motion has the views that are looked at.
  bool is_shown_by(const SeenMotion& seen) const;

  /// From the last place seen. @throws ArgumentError before a fit, and for a motion of other components or known
  /// numbers
  Eigen::RowVectorXd moved(const SeenMotion& seen, const Eigen::VectorXd& known) const;
  /// The same as found without a part of the training.
  Eigen::RowVectorXd moved_without(std::size_t part, const SeenMotion& seen,
                                   const Eigen::VectorXd& known) const;

 private:
  /// @returns by how much the sum of distances is less than that of the first prediction; 0 where nothing was fitted
  double learn(std::span<const TurningMoment> moments);
  Turning features_of(const SeenMotion& seen, const Eigen::VectorXd& known) const;
  void check_asked(const SeenMotion& seen) const;
  /// At the places of the whole way back.
  Eigen::MatrixXcd views_of(const SeenMotion& seen) const;

  Components components_ = {};
  double way_back_ = 0.0;
  Eigen::Index views_ = 0;                 ///< numbers of views
  Eigen::MatrixXd polynomials_ = {};       ///< degrees x places
  Eigen::MatrixXd view_polynomials_ = {};  ///< the same; empty: views are not looked at
  CovariantRegression regression_ = {};
};

}  // namespace samara::identification
