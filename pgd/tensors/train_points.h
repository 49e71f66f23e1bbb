#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/tensors/index_batch.h"
#include "samara/pgd/tensors/tensor_train.h"

/// Trains whose first mode is a list of outputs, at many points of the other modes at once.
namespace samara::pgd {

/// All outputs at entries of the grid, one column each. Products of cores that an entry shares with the one
/// before it, from the last mode on, are formed once. O(entries d r^2).
Eigen::MatrixXd values_at(const TensorTrain& train, const IndexBatch& entries);

/// All outputs at points off the grid, one column each.
/// @param points axes x points
Eigen::MatrixXd values_at(const TensorTrain& train, const std::vector<Axis>& axes,
                          const Eigen::MatrixXd& points);

/// The same to rounding, at many points: products of matrices per mode, element and block of points, on all threads of
/// the arena in which it is called. What values_at() reads of every core for each point, this reads once for the points
/// of a block that lie in the same element.
Eigen::MatrixXd many_values_at(const TensorTrain& train, const std::vector<Axis>& axes,
                               const Eigen::MatrixXd& points);

/// From values at the nodes to values at points: points x nodes.
Eigen::MatrixXd interpolation_matrix(const Axis& from, const Eigen::VectorXd& points);

/// The same functions on other axes, mode k + 1 carried over to `to[k]` by interpolation on `from[k]`.
TensorTrain carried_over(TensorTrain train, const std::vector<Axis>& from, const std::vector<Axis>& to);

}  // namespace samara::pgd
