#pragma once

#include <functional>
#include <vector>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/evolution/polynomial_system.h"
#include "samara/pgd/tensors/tensor_train.h"

namespace samara::pgd {

/// Times a power of the coordinate of mode `mode`, whose nodes are given.
TensorTrain times_nodes(TensorTrain train, int mode, const Eigen::VectorXd& nodes, int power = 1);

/// factor * (the powers of a monomial), over time nodes and the parameter axes; the monomial's own
/// coefficient does not enter.
/// @param state the train of one state
/// @param product entry by entry, compressed at once
TensorTrain monomial_product(
    const Monomial& monomial, double factor, int times, const std::vector<Axis>& parameters,
    const std::function<TensorTrain(int)>& state,
    const std::function<TensorTrain(const TensorTrain&, const TensorTrain&)>& product);

}  // namespace samara::pgd
