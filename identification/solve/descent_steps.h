#pragma once

#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "samara/identification/problem/chart.h"
#include "samara/identification/solve/secant_model.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Internal to identification/: what steps of own and of shared unknowns have in common in separable_descent.h.
namespace samara::identification {

constexpr double kFirstDamping = 1e-4;
constexpr double kMostDamping = 1e10;
/// A relative change of a cost that rounding hides.
constexpr double kCostRounding = 1e-13;

/// Directions of a block that are not held at a bound: those at one move only if the cost falls inwards.
/// @param first number of the block's first direction @param free they are added to it
void add_free(const std::vector<models::FamilyCoordinate>& box, const Chart& chart,
              const Eigen::VectorXd& values, const Eigen::Ref<const Eigen::VectorXd>& gradient, int first,
              std::vector<int>& free);

/// `values` moved by a step, and back into the box.
Eigen::VectorXd moved(const std::vector<models::FamilyCoordinate>& box, const Chart& chart,
                      const Eigen::VectorXd& values, const Eigen::Ref<const Eigen::VectorXd>& step);

Eigen::VectorXd step_between(const Chart& chart, const Eigen::VectorXd& from, const Eigen::VectorXd& to);

/// The next damping after a step that lowered the cost by `gain_ratio` of what was predicted.
double damping_after(double damping, double gain_ratio);

/// After a step that failed: forgets what was learned, or damps more where nothing was.
void harden(SecantModel& model, double& damping);

/// g^T H^-1 g on the free directions, by J^T W J and by what was learned, whichever is larger: twice what a
/// step could gain.
double decrement(const SecantModel& model, const Eigen::VectorXd& gradient, const std::vector<int>& free);

/// The inverse of a matrix on the free directions, made positive if it is not.
class FreeInverse {
 public:
  /// `free` must outlive it.
  FreeInverse(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& normal, const std::vector<int>& free);
  Eigen::MatrixXd times(const Eigen::MatrixXd& right) const;

 private:
  const std::vector<int>& free_;
  Eigen::VectorXd scale_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

}  // namespace samara::identification
