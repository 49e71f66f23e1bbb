#pragma once

#include <memory>

#include <Eigen/Core>

#include "samara/identification/fit_problem.h"
#include "samara/identification/trajectory_source.h"

/// Internal to identification/.
namespace samara::identification {

/// Residuals of one segment, and their derivatives by the shared and its own unknowns. Holds the scratch
/// space of one thread; `problem` must outlive it. Does not allocate after construction, beyond what the
/// source does.
class SegmentResidual {
 public:
  SegmentResidual(const TrajectoryFamily& family, const FitProblem& problem, const Segment& segment);

  /// @param shared, own values of the unknowns, in the order of the problem
  /// @returns false if there is no trajectory there
  bool evaluate(const double* shared, const double* own, bool with_derivatives);

  const Segment& segment() const { return *segment_; }
  int size() const { return static_cast<int>(residual_.size()); }
  long evaluations() const { return evaluations_; }

  /// (model - measured)/scale, per observation.
  const Eigen::VectorXd& residual() const { return residual_; }
  /// Observations x shared unknowns, and observations x own unknowns.
  const Eigen::MatrixXd& by_shared() const { return by_shared_; }
  const Eigen::MatrixXd& by_own() const { return by_own_; }
  /// The model's outputs without offsets, frames x outputs, SI.
  const Eigen::MatrixXd& values() const { return values_; }

  /// The offsets that make the mean residual of each output zero at the last point.
  void centre_offsets(Eigen::VectorXd& own) const;

 private:
  void load(const double* shared, const double* own);
  void fill_derivatives();

  const FitProblem* problem_;
  const Segment* segment_;
  std::unique_ptr<TrajectorySource> source_;
  Eigen::VectorXd q_;
  Eigen::MatrixXd values_;
  Eigen::MatrixXd derivatives_;
  Eigen::VectorXd residual_;
  Eigen::MatrixXd by_shared_;
  Eigen::MatrixXd by_own_;
  long evaluations_ = 0;
};

}  // namespace samara::identification
