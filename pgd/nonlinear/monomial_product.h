#pragma once

#include <functional>
#include <vector>

#include "samara/pgd/evolution/polynomial_system.h"
#include "samara/pgd/nonlinear/strategy_slab.h"
#include "samara/pgd/tensors/tensor_train.h"

namespace samara::pgd {

/// Times a power of the coordinate of mode `mode`, whose nodes are given.
TensorTrain times_nodes(TensorTrain train, int mode, const Eigen::VectorXd& nodes, int power = 1);

/// A term of a rate at the Radau points, in scales per slab. Its coefficient, all scales and the parameters come first,
/// exactly; then the states, which are of the order of one, so that what a product is rounded by does not grow in later
/// ones.
/// @param state the train of one state at the Radau points, over its scale
/// @param product entry by entry, compressed at once
TensorTrain monomial_product(
    const Monomial& monomial, const StrategySlab& slab, const std::function<TensorTrain(int)>& state,
    const std::function<TensorTrain(const TensorTrain&, const TensorTrain&)>& product);

}  // namespace samara::pgd
