#pragma once

#include <exception>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <ceres/ceres.h>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"

/// Internal to minimize.cpp: a fit's unknowns, residuals and charts as Ceres takes them.
namespace samara::identification {

/// All unknowns in one block of memory. Ceres orders parameter blocks by their addresses, and with the order
/// the rounding of its sums: separate blocks would give other bits in every run.
class Unknowns {
 public:
  Unknowns(const FitPoint& point, int shared, int own);

  double* shared() { return values_.data(); }
  double* own(std::size_t segment) { return values_.data() + place(segment); }
  void store(FitPoint& point) const;
  const Eigen::VectorXd& values() const { return values_; }

 private:
  Eigen::Index place(std::size_t segment) const {
    return shared_ + own_ * static_cast<Eigen::Index>(segment);
  }

  int shared_;
  int own_;
  Eigen::VectorXd values_;
};

/// All segments at one point, each by one thread at a time, before Ceres asks for them one by one. What is known of the
/// point already is not evaluated again.
class Evaluation final : public ceres::EvaluationCallback {
 public:
  Evaluation(std::vector<SegmentResidual>& residuals, Unknowns& unknowns)
      : residuals_(residuals), unknowns_(unknowns), is_finite_(residuals.size(), 0) {}

  void PrepareForEvaluation(bool evaluate_jacobians, bool /*new_point*/) override {
    evaluate(evaluate_jacobians);
  }

  /// Whether a segment has finite residuals at the last point, and derivatives if Ceres wanted them.
  bool is_finite_at(std::size_t segment) const { return is_finite_[segment] != 0; }
  /// Whether all segments have finite residuals and derivatives where the unknowns are now.
  /// @throws what a source throws
  bool all_are_finite();
  /// What was not finite at the last point, as failure_of() says it.
  std::string failure() const { return failure_of(residuals_); }
  /// What a source threw; not through Ceres.
  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  /// Where the unknowns are now.
  void evaluate(bool with_derivatives);

  std::vector<SegmentResidual>& residuals_;
  Unknowns& unknowns_;
  std::vector<char> is_finite_;
  std::optional<Eigen::VectorXd> point_;  ///< the last one; none at first, and after a source threw
  bool has_derivatives_ = false;          ///< of the last point
  std::exception_ptr thrown_;
};

/// The residuals of one segment: sign(r) sqrt(rho(r)), so that half their squares sum to the cost, frame by
/// frame (a ceres::LossFunction would see all frames of a capture as one residual). The derivative is
/// psi/sqrt(rho) times that of r. Joins have no loss. All of it goes with the weight of the motion.
class SegmentCost final : public ceres::CostFunction {
 public:
  SegmentCost(const FitProblem& problem, const SegmentResidual& residual, const Evaluation& evaluation,
              std::size_t number);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  void add_block(int size, const Eigen::MatrixXd& derivatives);

  LossKind loss_;
  double root_weight_;
  const SegmentResidual& residual_;
  const Evaluation& evaluation_;
  std::size_t number_;
  std::vector<const Eigen::MatrixXd*> blocks_;
};

/// What was known of the shared unknowns beforehand.
class PriorCost final : public ceres::CostFunction {
 public:
  explicit PriorCost(const FitProblem& problem);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  std::vector<PriorTerm> priors_;
};

/// A chart as Ceres takes it.
class ChartManifold final : public ceres::Manifold {
 public:
  explicit ChartManifold(Chart chart) : chart_(std::move(chart)) {}

  int AmbientSize() const override { return chart_.size(); }
  int TangentSize() const override { return chart_.directions(); }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  Chart chart_;
};

}  // namespace samara::identification
