#include "samara/pgd/nonlinear/separated_rates.h"

#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

TensorTrain separated_rates(const StrategySlab& slab, const TensorTrain& iterate, CrossPivots& pivots) {
  const TensorTrain at_points = slab.at_points(iterate);
  const EntryFunction function = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
    values = slab.rates(values_at(at_points, entries), slab.parameters_at(entries));
  };
  const double tolerance = kSourceShare * slab.tolerance();
  return slab.compressed(slab.separate(function, slab.rows(), tolerance, pivots, "f"), tolerance);
}

TensorTrain separated_jacobian(const StrategySlab& slab, const TensorTrain& iterate, double tolerance,
                               CrossPivots& pivots) {
  const TensorTrain at_points = slab.at_points(iterate);
  const EntryFunction function = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
    values = slab.jacobians(values_at(at_points, entries), slab.parameters_at(entries));
  };
  const int outputs = slab.states() * slab.rows();
  return slab.compressed(slab.separate(function, outputs, tolerance, pivots, "the Jacobian of f"), tolerance);
}

Eigen::MatrixXd source_at(const StrategySlab& slab, const Eigen::MatrixXd& rates, const Eigen::MatrixXd& x,
                          const Eigen::MatrixXd& jacobians) {
  const Eigen::Index n = slab.states();
  Eigen::MatrixXd source = rates;
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    for (Eigen::Index i = 0; i < slab.points(); ++i) {
      const Eigen::Map<const Eigen::MatrixXd> jacobian(jacobians.col(j).data() + n * n * i, n, n);
      source.col(j).segment(n * i, n).noalias() -= jacobian * x.col(j).segment(n * i, n);
    }
  }
  return source;
}

}  // namespace samara::pgd
