#include "samara/pgd/nonlinear/monomial_product.h"

#include <cmath>
#include <utility>

namespace samara::pgd {

TensorTrain times_nodes(TensorTrain train, int mode, const Eigen::VectorXd& nodes, int power) {
  TrainCore& core = train.cores[static_cast<std::size_t>(mode)];
  const Eigen::ArrayXd factors = nodes.array().pow(power);
  for (int r = 0; r < core.right; ++r) {
    for (int i = 0; i < core.size; ++i)
      core.data.segment(core.left * (i + Eigen::Index{core.size} * r), core.left) *= factors[i];
  }
  return train;
}

TensorTrain monomial_product(
    const Monomial& monomial, const StrategySlab& slab, const std::function<TensorTrain(int)>& state,
    const std::function<TensorTrain(const TensorTrain&, const TensorTrain&)>& product) {
  const std::vector<Axis>& parameters = slab.problem().parameters;
  double factor = monomial.coefficient * slab.length() / slab.scales()[monomial.state];
  for (std::size_t m = 0; m < monomial.state_powers.size(); ++m)
    factor *= std::pow(slab.scales()[static_cast<Eigen::Index>(m)], monomial.state_powers[m]);
  TensorTrain result;
  result.cores.emplace_back(1, slab.points(), 1);
  for (const Axis& axis : parameters) result.cores.emplace_back(1, axis.size(), 1);
  for (TrainCore& core : result.cores) core.data.setOnes();
  result.cores[0].data *= factor;
  for (std::size_t k = 0; k < monomial.parameter_powers.size(); ++k) {
    const int power = monomial.parameter_powers[k];
    if (power > 0)
      result = times_nodes(std::move(result), static_cast<int>(k) + 1, parameters[k].nodes(), power);
  }
  for (std::size_t m = 0; m < monomial.state_powers.size(); ++m) {
    for (int p = 0; p < monomial.state_powers[m]; ++p) result = product(result, state(static_cast<int>(m)));
  }
  return result;
}

}  // namespace samara::pgd
