#pragma once

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/cross/cross_interpolation.h"
#include "samara/pgd/cross/field_functions.h"
#include "samara/pgd/tensors/random.h"

/// A function given at the nodes of axes, as a separated field: what functions of fields and functions of
/// coordinates share.
namespace samara::pgd {

/// Sets `values` (the outputs) at a node: one index per axis.
using NodeFunction = std::function<void(Eigen::Ref<const Eigen::VectorXi> node, Eigen::VectorXd& values)>;

/// By cross interpolation, separation and a check at random nodes; see field_functions.h for what the result
/// says. @throws ArgumentError if an option is out of range.
FunctionResult approximate_nodal(const std::vector<Axis>& axes, std::vector<OutputLabel> outputs,
                                 const NodeFunction& function, const FunctionOptions& options);

std::vector<int> sizes_of(const std::vector<Axis>& axes);
std::vector<double> coordinates(const std::vector<Axis>& axes, const std::vector<int>& node);
/// Of many nodes at once: axes x nodes.
Eigen::MatrixXd coordinates_at(const std::vector<Axis>& axes, const IndexBatch& nodes);
/// Corners of the box, one column each; none of more than `most_axes`, which have too many.
Eigen::MatrixXd corner_points(const std::vector<Axis>& axes, std::size_t most_axes = 5);
/// Uniform in the box, one column each.
Eigen::MatrixXd random_points(const std::vector<Axis>& axes, int count, Random& random);
/// "t = 0.1 s, C_D = 1.2 1"
std::string described(const std::vector<Axis>& axes, const std::vector<double>& x);
IndexBatch random_nodes(const std::vector<int>& sizes, int count, Random& random);
/// All outputs of a field at one node. @param products workspace
void values_at(const SeparatedField& field, Eigen::Ref<const Eigen::VectorXi> node, Eigen::VectorXd& products,
               Eigen::Ref<Eigen::VectorXd> values);

}  // namespace samara::pgd
