#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/solve/motion_terms.h"

/// Internal to identification/: what posterior.h draws from, over the directions in which unknowns move.
namespace samara::identification {

/// Where directions of a problem lie: shared ones, then those of every segment.
struct DirectionLayout {
  explicit DirectionLayout(const FitProblem& problem)
      : shared(problem.shared_chart.directions()),
        own(problem.own_chart.directions()),
        all(shared + own * static_cast<int>(problem.segments.size())) {}
  int first_of(std::size_t segment) const { return shared + own * static_cast<int>(segment); }
  int shared, own, all;
};

/// A direction of an unknown with a box. Its value, or its logarithm, moves by the step along it.
struct BoxedDirection {
  int direction;        ///< of all
  std::size_t segment;  ///< of an own unknown
  bool is_shared, is_logarithmic;
  Eigen::Index unknown;
  double lower, upper;  ///< of the value, or of its logarithm

  double place(const FitPoint& point) const;
  /// Time until a wall is met at a velocity.
  double time_to_wall(const FitPoint& point, double velocity) const;
};

/// The density, its slope, and its curvature.
class PosteriorDensity {
 public:
  /// @param residuals one per segment, joined as those to be made
  PosteriorDensity(const models::TrajectoryFamily& family, const FitProblem& problem,
                   const std::vector<SegmentResidual>& residuals, double dispersion);

  const DirectionLayout& layout() const { return layout_; }
  const std::vector<BoxedDirection>& boxed() const { return boxed_; }
  long evaluations() const { return evaluations_of(residuals_); }

  /// -log of the density in the box; infinite where a residual or a slope is not finite, as without a trajectory.
  /// @param slope by directions
  double operator()(const FitPoint& point, Eigen::VectorXd& slope);
  /// Why it is infinite at the last point, in half a sentence.
  std::string failure() const;

  /// About the curvature of -log of the density at the last point, positive: residuals beyond the bend of the loss
  /// count as it weighs them, boxes and turns as uniform distributions.
  Eigen::MatrixXd curvature(const FitPoint& point) const;

  /// Second derivative of -log of the density at the last point, that of trajectories left out; boxes count for
  /// nothing.
  Eigen::MatrixXd second_derivative(const FitPoint& point) const;
  /// 1/2 sum of rho over the compared values at the last point, and how many they are.
  struct DataCost {
    double cost = 0.0;
    Eigen::Index values = 0;
  };
  DataCost data_cost(const FitPoint& point) const;
  void set_dispersion(double dispersion) { dispersion_ = dispersion; }

 private:
  Eigen::VectorXd weights(const MotionEquations& equations) const;
  double cost(const MotionEquations& equations) const;
  /// @param by_slope whether residuals beyond the bend of the loss count as it weighs them; else as it bends
  Eigen::MatrixXd normal_matrix(const FitPoint& point, bool by_slope) const;

  const FitProblem& problem_;
  const DirectionLayout layout_;
  const std::vector<BoxedDirection> boxed_;
  double dispersion_;
  std::vector<SegmentResidual> residuals_;
};

}  // namespace samara::identification
