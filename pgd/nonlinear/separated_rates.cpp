#include "samara/pgd/nonlinear/separated_rates.h"

#include <utility>

#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Rounded to the tolerance it was separated to.
Outcome<TensorTrain> rounded_if_found(const StrategySlab& slab, Outcome<TensorTrain> separated,
                                      double tolerance) {
  if (!separated) return separated;
  return slab.compressed(std::move(*separated), tolerance);
}

}  // namespace

Outcome<TensorTrain> separated_rates(const StrategySlab& slab, const TensorTrain& iterate,
                                     CrossPivots& pivots) {
  const TensorTrain at_points = slab.at_points(iterate);
  const EntryFunction function = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
    values = slab.rates(values_at(at_points, entries), slab.parameters_at(entries));
  };
  const double tolerance = kSourceShare * slab.tolerance();
  return rounded_if_found(slab, slab.separate(function, slab.rows(), tolerance, pivots, "f"), tolerance);
}

Outcome<TensorTrain> separated_jacobian(const StrategySlab& slab, const TensorTrain& iterate,
                                        double tolerance, CrossPivots& pivots) {
  return rounded_if_found(slab, separated_jacobian_at(slab, slab.at_points(iterate), tolerance, pivots),
                          tolerance);
}

Outcome<TensorTrain> separated_jacobian_at(const StrategySlab& slab, const TensorTrain& states,
                                           double tolerance, CrossPivots& pivots) {
  const EntryFunction function = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
    values = slab.jacobians(values_at(states, entries), slab.parameters_at(entries));
  };
  return slab.separate(function, slab.states() * slab.rows(), tolerance, pivots, "the Jacobian of f");
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
