#include "samara/pgd/nonlinear/linear_slab.h"

#include <utility>

#include <Eigen/LU>

#include "samara/base/parallel.h"
#include "samara/pgd/evolution/slab_collocation.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

constexpr double kCrossShare = 0.1;
constexpr double kRoundingShare = 0.1;

TensorTrain integrate(const StrategySlab& slab, const LinearSlab& linear) {
  const int s = slab.points();
  Eigen::MatrixXd integration = Eigen::MatrixXd::Zero(s + 1, s);
  integration.bottomRows(s) = slab.integration();
  return sum(slab.constant(), applied(linear.source, 0, for_all_states(integration, slab.states())));
}

/// Columns: solutions at entries.
Eigen::MatrixXd solve_at(const StrategySlab& slab, const LinearSlab& linear, const IndexBatch& entries) {
  const Eigen::Index n = slab.states();
  const Eigen::Index s = slab.points();
  const Eigen::MatrixXd& integration = slab.integration();
  const Eigen::MatrixXd jacobians = values_at(*linear.jacobian, entries);
  const Eigen::MatrixXd sources = values_at(linear.source, entries);
  const Eigen::MatrixXd starts = values_at(slab.start(), entries);
  Eigen::MatrixXd solutions(n * (s + 1), entries.cols());
  parallel_for(entries.cols(), [&](Eigen::Index e) {
    Eigen::MatrixXd rhs = sources.col(e).reshaped(n, s) * integration.transpose();
    rhs.colwise() += starts.col(e);
    solutions.col(e).head(n) = starts.col(e);
    solutions.col(e).tail(n * s) = collocation_matrix(integration, jacobians.col(e).reshaped(n * n, s))
                                       .partialPivLu()
                                       .solve(Eigen::VectorXd(rhs.reshaped()));
  });
  return solutions;
}

}  // namespace

Outcome<TensorTrain> solve(const StrategySlab& slab, const LinearSlab& linear, CrossPivots& pivots) {
  const double rounding = kRoundingShare * slab.tolerance();
  if (!linear.jacobian) return slab.compressed(integrate(slab, linear), rounding);
  const EntryFunction function = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
    values = solve_at(slab, linear, entries);
  };
  Outcome<TensorTrain> solution = slab.separate(function, slab.states() * (slab.points() + 1),
                                                kCrossShare * slab.tolerance(), pivots, "the solution");
  if (!solution) return solution;
  return slab.compressed(std::move(*solution), rounding);
}

}  // namespace samara::pgd
