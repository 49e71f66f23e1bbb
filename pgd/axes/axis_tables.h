#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "samara/pgd/axes/axis_transform.h"
#include "samara/pgd/axes/basis.h"
#include "samara/pgd/axes/lagrange.h"

/// What an axis is made of. Axis is how it is used.
namespace samara::pgd {

using SparseMatrix = Eigen::SparseMatrix<double>;

enum class AxisRole { time, space, parameter, initial, boundary };

/// The names used in files: "time", "space", "parameter", "initial", "boundary".
std::string to_string(AxisRole role);
/// @throws ArgumentError for an unknown name.
AxisRole role_from_string(const std::string& name);

struct AxisLabel {
  std::string name;
  std::string unit = "1";
  AxisRole role = AxisRole::parameter;
  Transform transform = Transform::none;  ///< of the kinds with elements
};

/// Weights of the nodes that a point touches: u(x) = sum_j value[j] u[first + j], likewise for du/dx.
struct InterpolationStencil {
  int first = 0;
  Eigen::VectorXd value;
  Eigen::VectorXd derivative;
};

/// The numbers of an axis, which its family fills in. Matrices as in Axis.
struct AxisTables {
  AxisLabel label;
  Basis basis = Basis::p1;
  AxisFamily family = AxisFamily::elements;  ///< that of the basis, at hand where points are evaluated
  double lower = 0.0, upper = 0.0, measure = 0.0;
  Eigen::VectorXd borders;             ///< of the elements; empty without
  std::optional<LagrangeBasis> local;  ///< on one element
  Eigen::VectorXd nodes;
  Eigen::VectorXd weights;
  SparseMatrix mass;
  std::optional<SparseMatrix> gradient, stiffness, derivative;
};

}  // namespace samara::pgd
