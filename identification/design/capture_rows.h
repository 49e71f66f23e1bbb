#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/design/experiment.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"

/// Internal to identification/: what one capture would say of the coefficients.
namespace samara::identification {

/// Derivatives of all that one capture shows, over its noise: by the coefficients in units of their errors so
/// far, then by the directions in which the capture's own unknowns move.
struct CaptureRows {
  Eigen::MatrixXd by_unknowns;       ///< first what is seen, then what was known of own unknowns beforehand
  std::vector<int> frames, outputs;  ///< of each row of what is seen
  int coefficients = 0;

  int seen() const { return static_cast<int>(frames.size()); }
  int unknowns() const { return static_cast<int>(by_unknowns.cols()); }

  /// by_unknowns^T by_unknowns of the rows for which `keeps(frame, output)`, and of what was known beforehand.
  Eigen::MatrixXd normal(const std::function<bool(int frame, int output)>& keeps) const;
  Eigen::MatrixXd normal() const;
};

/// The part of the coefficients, own unknowns eliminated. Own unknowns that are not determined leave nothing in it.
Eigen::MatrixXd eliminated(const Eigen::MatrixXd& normal, int coefficients);

/// One capture more as the fit would see it. Holds the scratch space of one thread.
class NextCapture {
 public:
  /// @param family must outlive it, as `known`
  /// @throws ArgumentError as fit() for captures that it cannot take
  NextCapture(const models::TrajectoryFamily& family, const Experiment& experiment, const KnownSoFar& known);
  NextCapture(const NextCapture&) = delete;
  NextCapture& operator=(const NextCapture&) = delete;

  /// @param coefficients SI
  /// @param release in the order of Experiment::coordinates, SI; an attitude of any length
  /// @returns false where the trajectory does not reach the end, or an output or its derivative is not finite
  bool evaluate(const Eigen::VectorXd& coefficients, const std::vector<double>& release, CaptureRows& rows);

  long evaluations() const { return residual_.evaluations(); }

 private:
  bool is_inside(const Eigen::VectorXd& own) const;

  Eigen::VectorXd errors_;
  std::size_t own_count_;
  FitProblem problem_;
  SegmentResidual residual_;
};

}  // namespace samara::identification
