#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/evolution/evolution_problem.h"

namespace samara::pgd {

/// States along training trajectories, one column each, with time and parameters.
struct TrainingStates {
  Eigen::VectorXd t;
  Eigen::MatrixXd x;  ///< states x samples, SI
  Eigen::MatrixXd q;  ///< parameters x samples
};

/// Trajectories from the corners of the parameter box (up to 2^7; without them beyond) and its centre,
/// marched point by point by collocation. A trajectory that cannot be followed ends where it cannot.
/// @param samples states per Radau point of the problem's time axis
/// @param evaluations those of f are added
TrainingStates train_along(const EvolutionProblem& problem, int samples, double tolerance, long& evaluations);

/// A system whose f is a weighted sum of linearisations, PPWL, (6.31)-(6.32):
///
///   f(x, q) = sum_i w_i(x) (f_i(q) + J_i(q) (x - x_i)),
///   w_i ~ exp(-beta (d_i^2 - d_min^2) / fill^2), sum_i w_i = 1.
///
/// The x_i are picked greedily among training states, the farthest from those picked so far next, in states
/// over their spread; states that f does not depend on do not count. f_i and J_i are affine in q: exactly if
/// f is, else f_i by its slopes at the parameters of the training state, and J_i at them.
class PiecewiseLinearSystem final : public EvolutionSystem {
 public:
  /// @throws ArgumentError if there are no points, or fewer training states than points.
  PiecewiseLinearSystem(const EvolutionSystem& system, const TrainingStates& training, int points);

  int state_count() const override { return static_cast<int>(centres_.rows()); }
  int point_count() const { return static_cast<int>(centres_.cols()); }
  /// @param x states x samples, SI @returns points x samples
  Eigen::MatrixXd weights(const Eigen::MatrixXd& x) const;
  /// f_i(q) - J_i(q) x_i: coefficient of q_k (k = 0: of one), states x points.
  const Eigen::MatrixXd& source(int k) const { return sources_[static_cast<std::size_t>(k)]; }
  /// J_i(q), likewise, states^2 x points, column after column.
  const Eigen::MatrixXd& jacobian(int k) const { return jacobians_[static_cast<std::size_t>(k)]; }
  /// Evaluations of f and J that the linearisations took.
  long rhs_evaluations() const { return rhs_evaluations_; }
  long jacobian_evaluations() const { return jacobian_evaluations_; }

  void rhs(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
           Eigen::MatrixXd& f) const override;
  /// With the weights held fixed.
  void jacobian(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                Eigen::MatrixXd& jacobian) const override;

 private:
  std::vector<Eigen::Index> pick(const EvolutionSystem& system, const TrainingStates& training, int points);
  /// @param sizes of the parameters, by which they are varied
  void linearise(const EvolutionSystem& system, const TrainingStates& points, const Eigen::VectorXd& sizes);

  Eigen::MatrixXd centres_;         ///< states x points, SI
  Eigen::VectorXd inverse_spread_;  ///< of every state; 0: f does not depend on it
  double sharpness_ = 0.0;          ///< beta / fill^2
  std::vector<Eigen::MatrixXd> sources_, jacobians_;
  long rhs_evaluations_ = 0, jacobian_evaluations_ = 0;
};

}  // namespace samara::pgd
