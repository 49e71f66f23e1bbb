#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/evolution/evolution_problem.h"
#include "samara/pgd/fields/train_field.h"
#include "samara/pgd/tensors/tensor_train.h"

/// Trains of states over parameters. The first mode of a train over a slab joins states and time, states
/// first: row m + states * i belongs to state m, over its scale, at time node i. One mode per parameter
/// follows.
namespace samara::pgd {

/// x0 over the axes: a sum of a constant and, for each state that starts at a coordinate, that coordinate.
/// Its first mode is the states.
TensorTrain initial_train(const std::vector<InitialValue>& initial, const Eigen::VectorXd& scales,
                          const std::vector<Axis>& parameters);

/// The last so many entries of the first mode: of a train over a slab, `states` of them are the state at its
/// end.
TensorTrain last_rows(const TensorTrain& train, int rows);

/// The field of a slab, in the units of the states.
TrainField slab_field(const Axis& time, const std::vector<Axis>& parameters,
                      const std::vector<OutputLabel>& states, const Eigen::VectorXd& scales,
                      const TensorTrain& slab);

}  // namespace samara::pgd
