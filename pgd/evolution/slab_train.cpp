#include "samara/pgd/evolution/slab_train.h"

#include <algorithm>
#include <utility>

#include "samara/pgd/tensors/train_algebra.h"

namespace samara::pgd {

TensorTrain initial_train(const std::vector<InitialValue>& initial, const Eigen::VectorXd& scales,
                          const std::vector<Axis>& parameters) {
  const auto on_axes = std::count_if(initial.begin(), initial.end(),
                                     [](const InitialValue& value) { return value.axis >= 0; });
  SeparatedTensor sum;
  sum.weights = Eigen::VectorXd::Ones(on_axes + 1);
  sum.factors.emplace_back(Eigen::MatrixXd::Zero(scales.size(), on_axes + 1));
  for (const Axis& axis : parameters)
    sum.factors.emplace_back(Eigen::MatrixXd::Ones(axis.size(), on_axes + 1));
  Eigen::Index term = 0;
  for (Eigen::Index m = 0; m < scales.size(); ++m) {
    const InitialValue& value = initial[static_cast<std::size_t>(m)];
    if (value.axis < 0) {
      sum.factors[0](m, 0) = value.value / scales[m];
      continue;
    }
    const auto axis = static_cast<std::size_t>(value.axis);
    sum.factors[0](m, ++term) = 1.0 / scales[m];
    sum.factors[axis + 1].col(term) = parameters[axis].nodes();
  }
  return rounded(to_train(sum), 1e-14 * norm(sum));
}

TensorTrain last_rows(const TensorTrain& train, int rows) {
  TensorTrain result = train;
  result.cores[0] = TrainCore(1, rows, train.cores[0].right);
  result.cores[0].left_unfolding() = train.cores[0].left_unfolding().bottomRows(rows);
  return result;
}

TrainField slab_field(const Axis& time, const std::vector<Axis>& parameters,
                      const std::vector<OutputLabel>& states, const Eigen::VectorXd& scales,
                      const TensorTrain& slab) {
  const auto n = static_cast<int>(scales.size());
  std::vector<Axis> axes = {time};
  axes.insert(axes.end(), parameters.begin(), parameters.end());
  TensorTrain train;
  train.cores.emplace_back(1, n, n);
  train.cores[0].left_unfolding() = scales.asDiagonal();
  // The joint mode, states first, lies in memory as a core of left size states.
  train.cores.emplace_back(n, time.size(), slab.cores[0].right);
  train.cores[1].data = slab.cores[0].data;
  train.cores.insert(train.cores.end(), slab.cores.begin() + 1, slab.cores.end());
  return {std::move(axes), states, std::move(train)};
}

}  // namespace samara::pgd
